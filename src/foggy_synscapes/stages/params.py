"""params: check a params file and say what it asks for."""

import argparse
from pathlib import Path

from foggy_synscapes.params import STAND_IN, Params, load

HELP = "Check a params file: unknown, missing, impossible or contradicting values are named."


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this command."""
    parser.add_argument("--file", type=Path, metavar="FILE", help="params file to check (default: the one of --params)")
    parser.add_argument("--check", action="store_true", help="only check: print nothing but that the file is good")


def run(args: argparse.Namespace) -> None:
    """Run the command."""
    path = args.file or args.params
    params = load(path)
    print(f"{path}: good")
    if not args.check:
        print("\n".join(summary(params)))


def summary(params: Params) -> list[str]:
    """What the experiment consists of, a line each."""
    lines = []
    for dataset, folder in params.scenes.roots.model_dump().items():
        lines.append(f"{dataset}: {'stand-in, rendered under results/scenes' if folder == STAND_IN else folder}")
    ends, betas = params.fog.frames, params.fog.betas
    lines.append(
        f"fog: {ends.first + ends.last} frames at beta {', '.join(betas)} 1/m, geometry {params.fog.geometry}, "
        f"{len(params.scenes.shards) * len(betas)} shards"
    )
    for row, entry in params.subset.rows().items():
        lines.append(
            f"{row}: {entry.train} training and {entry.validation} validation images ({params.subset.kind(row)})"
        )
    jobs = len(params.train.networks) * len(params.subset.rows()) * len(params.train.seeds)
    lines.append(
        f"train: {jobs} trainings of {', '.join(params.train.networks)}; seeds {', '.join(params.train.seeds)}"
    )
    lines.append(
        f"evaluate: {jobs * len(params.evaluate.test_sets)} evaluations on {', '.join(params.evaluate.test_sets)}"
    )
    return lines
