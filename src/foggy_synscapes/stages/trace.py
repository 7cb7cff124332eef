"""trace: what a result was made from, job by job, down to the raw data; or what one cell of a table comes from."""

import argparse
import json
import re
from pathlib import Path

from foggy_synscapes.datasets import test_sets
from foggy_synscapes.errors import UsageError
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.params import load
from foggy_synscapes.provenance.cell import cell_lines, trace_cell
from foggy_synscapes.provenance.crate import write_crate
from foggy_synscapes.provenance.lineage import Lineage, lines
from foggy_synscapes.provenance.picture import cell_svg, file_svg
from foggy_synscapes.results import roots

HELP = "Show, as a tree, the commands and files that a result was made from, and what on disk no longer matches."


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this step."""
    parser.add_argument("path", type=Path, nargs="?", help="a result, e.g. results/tables/foggy_driving.tex")
    parser.add_argument("--json", action="store_true", help="print everything as JSON")
    parser.add_argument("--depth", type=int, metavar="N", help="jobs to go back (default: down to the raw data)")
    parser.add_argument(
        "--cell",
        nargs=3,
        metavar=("NETWORK", "ROW", "SCORE"),
        help="instead of a file: one cell, e.g. RefineNet FS-498 sky, or ... 'mean IoU annotated'",
    )
    parser.add_argument(
        "--crate",
        type=Path,
        metavar="DIR",
        help="write a Workflow Run RO-Crate to this new folder, or FILE.zip, instead",
    )
    parser.add_argument(
        "--svg", type=Path, metavar="FILE", help="draw it instead: its jobs, those of a kind in one box, as FILE.svg"
    )
    parser.add_argument(
        "--date", default="1970-01-01", help="with --crate: its date of publication (default: 1970-01-01, for unknown)"
    )
    parser.add_argument(
        "--test-set", metavar="NAME", help="with --cell: whose table (default: the first of evaluate.test_sets)"
    )


def run(args: argparse.Namespace) -> None:
    """Run the command."""
    if (args.path is None) == (args.cell is None):
        raise UsageError("give a result, e.g. results/tables/foggy_driving.tex, or --cell NETWORK ROW SCORE")
    if args.cell is None and args.test_set is not None:
        raise UsageError("--test-set belongs to --cell")
    if args.depth is not None and (args.depth < 0 or args.cell is not None):
        raise UsageError(f"--depth {args.depth}: expected 0 or more jobs, and no --cell")
    if args.crate is not None and args.cell is not None:
        raise UsageError("--crate is of a result, not of a --cell")
    if args.svg is not None and (args.json or args.crate is not None or args.depth is not None):
        raise UsageError("--svg draws all that leads to a result: give it without --json, --crate and --depth")
    if re.fullmatch(r"[0-9]{4}-[0-9]{2}-[0-9]{2}", args.date) is None:
        raise UsageError(f"--date {args.date}: expected year, month and day, e.g. 2026-11-24")
    params = load(args.params)
    if args.test_set not in (None, *test_sets()):
        raise UsageError(f"--test-set {args.test_set}: there are {', '.join(test_sets())}")
    lineage = Lineage(roots(params))
    if args.cell is not None:
        cell = trace_cell(lineage, args.test_set or params.evaluate.test_sets[0], *args.cell)
        if args.svg is not None:
            _write(args.svg, cell_svg(lineage, cell))
            return
        print(json.dumps(cell, indent=1) if args.json else "\n".join(cell_lines(cell)))
        return
    if args.crate is not None:
        jobs = write_crate(lineage, args.path.as_posix(), args.crate, args.date)
        print(f"trace: {args.crate} tells of {args.path} and the {jobs} jobs behind it")
        return
    if args.svg is not None:
        _write(args.svg, file_svg(lineage, args.path.as_posix()))
        return
    tree = lineage.tree(args.path.as_posix(), args.depth)
    print(json.dumps(tree, indent=1) if args.json else "\n".join(lines(tree)))


def _write(path: Path, picture: str) -> None:
    write_text(path, picture)
    print(f"trace: {path}; a pointer on a box shows its commands")
