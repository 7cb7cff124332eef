"""`foggy croissant`: a Croissant description of foggy images that were made, for tools that find and load datasets."""

import argparse
import datetime
from pathlib import Path

from foggy_synscapes.errors import UsageError
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.params import load
from foggy_synscapes.provenance.croissant import croissant

HELP = (
    "Describe foggy images that were made, in the format Croissant: what they are, their shards and hashes, how they "
    "are read."
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="shards of one beta, e.g. results/fog/beta_0.005")
    parser.add_argument("--date", required=True, help="date of publication, e.g. 2026-11-24: run records hold none")
    parser.add_argument(
        "--out",
        type=Path,
        metavar="FILE",
        help="file to write, beside or above FOLDER (default: FOLDER.croissant.json)",
    )


def run(args: argparse.Namespace) -> None:
    """Run the command."""
    try:
        datetime.date.fromisoformat(args.date)
    except ValueError as error:
        raise UsageError(f"--date {args.date}: expected year, month and day, e.g. 2026-11-24") from error
    out = args.out or args.folder.with_name(f"{args.folder.name}.croissant.json")
    write_text(out, croissant(load(args.params), args.folder, args.date, out.parent))
    print(f"{out}: description of {args.folder}")
