"""clean: results that the params do not ask for any more, such as those of a test set that was dropped."""

import argparse
import shutil
from pathlib import Path

from foggy_synscapes.errors import UsageError
from foggy_synscapes.io import lock
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.params import Params, load
from foggy_synscapes.provenance.runs import read_runs
from foggy_synscapes.results import RESULTS, SCENES
from foggy_synscapes.steps import all_jobs

HELP = "List the results that the params do not ask for any more, and remove them. Raw data is never touched."


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this command."""
    parser.add_argument("--unused", action="store_true", help="what no job of the params makes (there is nothing else)")
    parser.add_argument("--dry-run", action="store_true", help="only list")
    parser.add_argument("--tex", type=Path, metavar="FILE", help="only tell the paper which files to leave out")


def run(args: argparse.Namespace) -> None:
    """Run the command."""
    if not args.unused:
        raise UsageError("say what: --unused")
    found = unused(load(args.params))
    if args.tex is not None:
        write_text(args.tex, "".join(f"\\expandafter\\def\\csname unused@{path}\\endcsname{{}}%\n" for path in found))
        return
    for path in found:
        print(path)
    if not args.dry_run:
        with lock.hold(against_dvc=True):
            remove(found)
    print(f"clean: {len(found)} results that {args.params} does not ask for{'' if args.dry_run else ' were removed'}")


def unused(params: Params) -> list[Path]:
    """Files that run records name, and the records, of jobs that the params do not ask for; drawn folders too."""
    jobs = all_jobs(params)
    asked = {path for job in jobs for path in (*job.outputs(), job.output("record"))}
    found = {path for place, record in read_runs().items() for path in (place, *map(Path, record["outputs"]))} - asked
    drawn = {path for path in Path(SCENES).glob("*") if path.name not in ("index", *params.scenes.roots)}
    inside = {path for path in found if path.is_relative_to(RESULTS) and not path.is_relative_to(SCENES)}
    indexes = {path for path in found if path.is_relative_to(f"{SCENES}/index")}
    return sorted(path for path in inside | indexes | drawn if path.exists())


def remove(paths: list[Path]) -> None:
    """Remove files and folders, and folders that are empty then."""
    for path in paths:
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink()
        for folder in path.parents:
            if folder == Path(RESULTS) or any(folder.iterdir()):
                break
            folder.rmdir()
