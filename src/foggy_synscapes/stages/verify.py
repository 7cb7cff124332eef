"""verify: hash results again and compare with what their run records say."""

import argparse
from pathlib import Path

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.runs import read_runs, state
from foggy_synscapes.progress import progress

HELP = "Hash results again and name every file that is not what its run record says."


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this command."""
    parser.add_argument("path", nargs="?", type=Path, default=Path("results"), help="file or folder (default: results)")


def run(args: argparse.Namespace) -> None:
    """Run the command; any difference is an error."""
    problems, count = verify(args.path)
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


def verify(path: Path) -> tuple[list[str], int]:
    """Compare the inputs and outputs of the records that have an output at or below `path`.

    Returns
    -------
    A line for each file that is missing, changed, or recorded with two contents; and the number of files compared.

    Raises
    ------
    FoggyError
        If no record speaks of `path`.
    """
    recorded: dict[str, dict[str, str]] = {}
    for place, record in read_runs().items():
        if any(Path(name).is_relative_to(path) for name in record["outputs"]):
            for name, digest in {**record["inputs"], **record["outputs"]}.items():
                recorded.setdefault(name, {})[digest] = str(place)
    if not recorded:
        raise FoggyError(f"{path}: no run record speaks of it. Paths are relative to the project's folder: results/...")
    problems = []
    for name, digests in progress(sorted(recorded.items()), "verify", unit="file"):
        states = {state(name, digest): place for digest, place in digests.items()}
        for word in ("missing", "changed"):
            if word in states:
                problems.append(f"{name}: {word} (recorded in {states[word]})")
    return problems, len(recorded)
