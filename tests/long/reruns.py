"""What a change makes run again, on both engines, as a table: `make reruns`.

    python tests/long/reruns.py [--run] [--only TEXT] [--clones DIR]

For each change of tests/helpers/changes.py, a finished smoke run is changed, and both engines are asked what is out of
date; that has to be exactly the listed jobs: one that lacks would leave a stale result, one too many is needless work.
With --run the change is also made in copies of the finished runs and carried through, by `dvc repro` and by Snakemake
step by step (`workflow/waves.py`); what really runs has to be the listed jobs too, and both engines' results have to be
equal, and equal to those of a clean run of the changed project. --clones keeps the finished runs for the next time.
"""

import argparse
import shutil
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "helpers"))

from changes import CHANGES, Change, make, matching
from engines import SMOKE, VERBOSE, clone, environment, for_dvc, hashes, own_sources, planned, ran, run
from plans import compare_plans, differences


def finished(folder: Path) -> tuple[Path, Path]:
    """Clones in which Snakemake and DVC ran the smoke chain to its end; made where they are not there."""
    snakemake, dvc = folder / "snakemake", folder / "dvc"
    if not snakemake.exists():
        run(clone(snakemake), "snakemake", "--cores", "2", *SMOKE)
    if not dvc.exists():
        run(for_dvc(clone(dvc)), "dvc", "repro")
    return snakemake, dvc


def compare_runs(change: Change, snakemake: Path, dvc: Path, folder: Path) -> tuple[set[str], set[str], list[str]]:
    """Jobs that each engine really ran after a change, and a line for each difference from what is listed."""
    copies = [Path(shutil.copytree(each, folder / each.name, symlinks=True)) for each in (snakemake, dvc)]
    for copy in copies:
        make(copy, change)
    jobs = planned(copies[0], "--forceall")
    waves = [sys.executable, "workflow/waves.py", *(change.options or ("--cores", "2")), *VERBOSE, *SMOKE]
    told = subprocess.run(
        waves, cwd=copies[0], env=environment(own_sources(copies[0])), capture_output=True, text=True, check=False
    )
    problems = [] if told.returncode == 0 else [f"Snakemake fails: {told.stdout[-800:]}{told.stderr[-800:]}"]
    first = ran(told.stdout + told.stderr)
    second = ran(run(copies[1], "dvc", "repro", changes=own_sources(copies[1])))
    listed = matching(jobs, change.direct if change.snakemake is None else change.snakemake)
    problems += differences("Snakemake runs", first, listed | matching(jobs, change.follow))
    listed = matching(jobs, change.direct if change.dvc is None else change.dvc) - matching(jobs, change.restored)
    problems += differences("DVC runs", second, listed | matching(jobs, (*change.follow, *(change.dvc_follow or ()))))
    clean = clone(folder / "clean")
    make_inputs(clean, change)
    run(clean, "snakemake", "--cores", "2", *SMOKE, changes=own_sources(clean))
    expected = hashes(clean)
    for copy in copies if change.snakemake is None else copies[1:]:
        left = {path: digest for path, digest in hashes(copy).items() if path in expected}
        problems += [
            f"{copy.name}: {path} is not that of a clean run" for path in expected if left.get(path) != expected[path]
        ]
    return first, second, problems


def make_inputs(clean: Path, change: Change) -> None:
    """Make the part of a change that concerns the project, not its results."""
    make(clean, replace(change, edits=tuple(edit for edit in change.edits if not edit.path.startswith("results/"))))


def summary(names: set[str]) -> str:
    """Jobs by step and number, e.g. `2 train, 4 evaluate`."""
    words = [name.split()[0] for name in names]
    order = ("scenes", "filter", "fog", "subset", "train", "evaluate", "tables", "figures", "stability")
    return ", ".join(f"{words.count(word)} {word}" for word in order if word in words) or "none"


def main() -> int:
    """Print the table; 1 where an engine would leave anything stale or do anything needless that is not listed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--run", action="store_true", help="also run what the change makes out of date (minutes each)")
    parser.add_argument("--only", default="", metavar="TEXT", help="only changes whose name holds this text")
    parser.add_argument(
        "--clones", type=Path, metavar="DIR", help="folder for the finished runs, kept for the next time"
    )
    options = parser.parse_args()
    failed, chosen = 0, [change for change in CHANGES if options.only in change.name]
    with tempfile.TemporaryDirectory() as scratch:
        snakemake, dvc = finished(options.clones or Path(scratch))
        titles = ["change", "out of date at once", *(["Snakemake ran", "DVC ran"] if options.run else []), "exceptions"]
        print("| " + " | ".join([*titles, "as listed"]) + " |\n|" + " --- |" * (len(titles) + 1), flush=True)
        for number, change in enumerate(chosen):
            direct, problems = compare_plans(change, snakemake, dvc)
            cells = [change.name, summary(direct)]
            if options.run:
                first, second, more = compare_runs(change, snakemake, dvc, Path(scratch) / f"run {number}")
                cells, problems = [*cells, summary(first), summary(second)], problems + more
                shutil.rmtree(Path(scratch) / f"run {number}")
            print("| " + " | ".join([*cells, change.note, "NO" if problems else "yes"]) + " |", flush=True)
            for problem in problems:
                print(f"    {problem}", file=sys.stderr, flush=True)
            failed += bool(problems)
    print(f"\n{len(chosen)} changes, {failed} not as listed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
