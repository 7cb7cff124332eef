"""What a change of raw data makes run again: `make reruns`.

    python tests/long/raw_changes.py [--run] [--clones DIR]

The finished smoke runs of both engines are given their Synscapes frames as a dataset of their own, outside of results/,
as real data is. Moving it there must train nothing. Then one file is changed: Snakemake has to notice that itself and
say what to do, and after the dataset was listed anew, the jobs out of date have to be those that read the index of the
shard; with --run, what follows has to be what the change reaches, and nothing else.
"""

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "helpers"))

from changes import FRAMES, PURE, Change, edit_params, make, matching, rows
from engines import SMOKE, environment, own_sources, planned, ran, run
from plans import differences, followers, out_of_date
from reruns import VERBOSE, finished, summary

LISTS = tuple(f"subset {row}" for row in PURE)
READ_INDEX = ("filter", "fog airlight 0000", "fog 0.005 0000", *LISTS, *FRAMES)
MOVED = Change("the dataset's folder moved", edit_params("synscapes: stand-in", "synscapes: data/its frames"))


def replaced(kind: str) -> Callable[[Path], object]:
    """Frame 1 gets the file of frame 2."""
    folder, _, ending = kind.partition(".")
    return lambda root: shutil.copy(root / folder / f"2.{ending}", root / folder / f"1.{ending}")


def meta(key: str, value: float) -> Callable[[Path], object]:
    """A scene key of frame 1 gets another value."""

    def write(root: Path) -> None:
        path = root / "meta/1.json"
        document = json.loads(path.read_text())
        assert document["scene"][key] != value
        document["scene"][key] = value
        path.write_text(json.dumps(document))

    return write


CASES = (
    ("one RGB image", replaced("img/rgb.png"), rows(*PURE)),
    ("one depth map", replaced("img/depth.exr"), rows(*PURE)),
    ("a meta value that no rule of the filter uses", meta("num_cars", 77), ("figures sky_contrast",)),
    ("a meta value that the filter uses", meta("sky_contrast", 9.0), ("fog *", "figures sky_contrast", *rows(*PURE))),
)


def moved(folder: Path) -> set[str]:
    """Put a clone's Synscapes frames outside of results/, run its engine, and give the jobs that ran."""
    shutil.copytree(folder / "results/scenes/synscapes", folder / "data/its frames")
    make(folder, MOVED)
    return carried_through(folder)


def carried_through(folder: Path) -> set[str]:
    """The jobs that ran until everything was up to date."""
    own = own_sources(folder)
    if (folder / ".git").is_dir():
        return ran(run(folder, "dvc", "repro", changes=own))
    call = [sys.executable, "workflow/waves.py", "--cores", "2", *VERBOSE, *SMOKE]
    told = subprocess.run(call, cwd=folder, env=environment(own), capture_output=True, text=True, check=False)
    assert told.returncode == 0, told.stdout[-2000:] + told.stderr[-2000:]
    return ran(told.stdout + told.stderr)


def listed_anew(folder: Path) -> None:
    """List a dataset after a change, as the README says; Snakemake has to ask for it."""
    own = own_sources(folder)
    if (folder / ".git").is_dir():
        run(folder, "dvc", "repro", "--single-item", "--force", "scenes_synscapes", changes=own)
        return
    call = [sys.executable, "-m", "snakemake", "--dry-run", "--cores", "1", *SMOKE]
    told = subprocess.run(call, cwd=folder, env=environment(own), capture_output=True, text=True, check=False)
    assert told.returncode, "Snakemake did not notice the change"
    assert "Run `foggy scenes --dataset synscapes" in told.stdout + told.stderr
    run(folder, "foggy_synscapes", "scenes", "--dataset", "synscapes", "--params", SMOKE[1], changes=own)


def main() -> int:
    """Print the table; 1 where anything is stale or needless."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--run", action="store_true", help="also run what the change makes out of date")
    parser.add_argument(
        "--clones", type=Path, metavar="DIR", help="folder for the finished runs, kept for the next time"
    )
    options = parser.parse_args()
    failed = 0
    with tempfile.TemporaryDirectory() as scratch:
        bases = []
        print("| engine | raw data | out of date, or ran | as listed |\n| --- | --- | --- | --- |", flush=True)
        for each in finished(options.clones or Path(scratch)):
            bases.append(Path(shutil.copytree(each, Path(scratch) / f"moved {each.name}", symlinks=True)))
            found = moved(bases[-1])
            # The indexes' run records say now that the data is real, and DVC depends on the folder that holds them.
            seconds = ("filter", "subset") if each.name == "dvc" else ()
            kept = {"filter", "fog", "subset", "train", "evaluate"}.difference(seconds)
            needless = {name for name in found if name.split()[0] in kept}
            print(f"| {each.name} | {MOVED.name} | {summary(found)} | {'NO' if needless else 'yes'} |", flush=True)
            failed += bool(needless)
        for base in bases:
            for name, edit, follow in CASES:
                folder = Path(shutil.copytree(base, Path(scratch) / "changed", symlinks=True))
                edit(folder / "data/its frames")
                listed_anew(folder)
                if (folder / ".git").is_dir():
                    found = out_of_date(folder)
                    # By the folder of the index, DVC finds what reads the other shard's index, too.
                    problems = differences("DVC", found, matching(found, READ_INDEX))
                else:
                    jobs = planned(folder, "--forceall")
                    found = set(planned(folder))
                    problems = differences("Snakemake", found, followers(jobs, matching(jobs, READ_INDEX)))
                print(f"| {base.name} | {name} | {summary(found)} | {'NO' if problems else 'yes'} |", flush=True)
                if options.run:
                    names = planned(folder, "--forceall")
                    found = carried_through(folder)
                    problems += differences(base.name, found, matching(names, (*READ_INDEX, *follow)))
                    print(
                        f"| {base.name} | {name}: ran | {summary(found)} | {'NO' if problems else 'yes'} |", flush=True
                    )
                for problem in problems:
                    print(f"    {problem}", file=sys.stderr, flush=True)
                failed += bool(problems)
                shutil.rmtree(folder)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
