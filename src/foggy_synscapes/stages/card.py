"""`foggy card`: a model card of a trained model, from its run record and scores."""

import argparse
from pathlib import Path

from foggy_synscapes.errors import UsageError
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.networks import NETWORKS
from foggy_synscapes.params import load
from foggy_synscapes.provenance.model_card import model_card

HELP = (
    "Write a model card in Markdown: what a model is, what it was trained on and how, what it scores, what it is for."
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("--network", required=True, help="network of the model, e.g. bisenet")
    parser.add_argument("--row", required=True, help="its row of the tables, e.g. FS-498")
    parser.add_argument("--seed", default="0", help="its seed (default: 0)")
    parser.add_argument("--out", type=Path, metavar="FILE", help="file to write instead of printing, .md")


def run(args: argparse.Namespace) -> None:
    """Run the command."""
    params = load(args.params)
    if args.network not in NETWORKS:
        raise UsageError(f"--network {args.network}: no such network; there are {', '.join(NETWORKS)}")
    card = model_card(params, args.network, args.row, args.seed)
    if args.out is None:
        print(card, end="")
    else:
        write_text(args.out, card)
        print(f"{args.out}: card of {args.network}, row {args.row}, seed {args.seed}")
