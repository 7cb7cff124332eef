"""verify: hash results again and compare with what their run records say; or make them again and compare."""

import argparse
from pathlib import Path

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.params import load
from foggy_synscapes.provenance import check
from foggy_synscapes.provenance.current import out_of_date
from foggy_synscapes.provenance.rebuild import options, rebuild
from foggy_synscapes.results import roots

HELP = "Hash results, and the stand-in that they come from, and name every file that is not what its record says."


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this step."""
    parser.add_argument("path", nargs="?", type=Path, default=Path("results"), help="file or folder (default: results)")
    parser.add_argument("--data", action="store_true", help="hash all raw data, too: minutes for a real dataset")
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
        verify_by_hashing(args.path, args.params, args.data)


def verify_by_hashing(path: Path, params: Path, data: bool = False) -> None:
    """Print how many files are as recorded, and what is out of date by the params; FoggyError naming those that differ.

    data : hash the raw data of all indexes there, too
    """
    count = check.verify(path, roots(load(params)) if data else None)
    print(f"verify: {count} files are what their run records say")
    stale = [again for again in out_of_date(load(params)) if again.node.is_there] if params.is_file() else []
    below = [again for again in stale if any(Path(name).is_relative_to(path) for name in again.node.written)]
    if below:
        print(f"{len(below)} jobs are out of date by {params}, first {below[0].node.name}: {below[0].why}")


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
