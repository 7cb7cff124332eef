"""verify: hash results again and compare with what their run records say."""

import argparse
from pathlib import Path

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.lineage.check import differences

HELP = "Hash results, and the stand-in that they come from, and name every file that is not what its record says."


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this step."""
    parser.add_argument("path", nargs="?", type=Path, default=Path("results"), help="file or folder (default: results)")


def run(args: argparse.Namespace) -> None:
    """Run the command."""
    verify(args.path)


def verify(path: Path) -> None:
    """Raise FoggyError naming every file that is missing or changed; print how many are as recorded otherwise."""
    problems, count = differences(path)
    if problems:
        raise FoggyError(
            "\n".join(
                [
                    f"{len(problems)} of {count} files differ from their run records:",
                    *problems,
                    "Delete them and run the engine again; it makes what is missing.",
                ]
            )
        )
    print(f"verify: {count} files are what their run records say")
