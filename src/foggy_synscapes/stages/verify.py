"""verify: hash results again and compare with what their run records say; or make them again and compare."""

import argparse
from pathlib import Path

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.provenance.check import differences
from foggy_synscapes.provenance.rebuild import options, rebuild

HELP = "Hash results, and the stand-in that they come from, and name every file that is not what its record says."


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this step."""
    parser.add_argument("path", nargs="?", type=Path, default=Path("results"), help="file or folder (default: results)")
    parser.add_argument(
        "--rebuild",
        choices=sorted(options()),
        metavar="STEP",
        help="instead, do the jobs of a step again in a scratch copy and compare the bytes: " + ", ".join(options()),
    )


def run(args: argparse.Namespace) -> None:
    """Run the command."""
    if args.rebuild:
        verify_by_rebuilding(args.rebuild, args.path, args.params)
    else:
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


def verify_by_rebuilding(word: str, path: Path, params: Path) -> None:
    """Do jobs again and print for each whether the bytes are the same; FoggyError if those of any are not."""
    different, files = [], 0
    for job in rebuild(word, path, params):
        files += job.outputs
        different += job.different
        found = f"DIFFERENT: {', '.join(job.different)}" if job.different else "the same"
        print(f"{job.command}: {found}", flush=True)
        for line in job.circumstances:
            print(f"  {line}")
    if different:
        raise FoggyError(
            f"{len(different)} of {files} files come out otherwise. docs/reproducibility.md says what can change bytes."
        )
    print(f"verify: {files} files come out as they are")
