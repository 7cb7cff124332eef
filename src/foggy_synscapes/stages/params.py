"""params: check a params file, print it complete with units and sources, or say what it asks for."""

import argparse
import sys
from pathlib import Path

from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.params import STAND_IN, Params, check, load, resolved
from foggy_synscapes.planning import asked, checks

HELP = (
    "Print a params file complete, with units and sources: its values laid on the packaged defaults. Sections are "
    "merged key by key; lists, lengths and mappings whose keys you name (lists of subset, train.rows) are replaced "
    "whole. Unknown, missing, impossible or contradicting values are named."
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this command."""
    parser.add_argument("--file", type=Path, metavar="FILE", help="params file to read (default: the one of --params)")
    parser.add_argument("--defaults", action="store_true", help="no file: the packaged defaults as they are")
    parser.add_argument(
        "--out", type=Path, metavar="FILE", help="file to write instead of printing, e.g. params.yaml for DVC"
    )
    what = parser.add_mutually_exclusive_group()
    what.add_argument(
        "--check",
        nargs="?",
        const="",
        metavar="FILE",
        help="only check, also what a run would lack: datasets, start weights, lists as long as a batch",
    )
    what.add_argument("--summary", action="store_true", help="print what the experiment consists of, a line each")
    what.add_argument("--schema", action="store_true", help="print the JSON Schema of params files, for editors")
    what.add_argument("--docs", action="store_true", help="print a page of all keys, as docs/parameters.md")


def run(args: argparse.Namespace) -> None:
    """Run the command."""
    if args.check is not None and args.out is not None:
        raise UsageError("--check writes nothing; leave out --out")
    text = _asked(args)
    if args.out is None:
        print(text, end="")
    else:
        write_text(args.out, text)


def _asked(args: argparse.Namespace) -> str:
    """What the options ask for, as text."""
    if args.schema or args.docs:
        from foggy_synscapes.params import reference

        defaults = resolved.document(check({}, "defaults"))
        return reference.json_schema() if args.schema else reference.markdown(defaults)
    path = args.file or Path(args.check or args.params)
    params = check({}, "defaults") if args.defaults else load(path)
    for warning in params.warnings():
        print(f"{path}: warning: {warning}", file=sys.stderr)
    if args.check is not None:
        _check(path, params)
        return f"{path}: good\n"
    return "\n".join(summary(params)) + "\n" if args.summary else resolved.text(params)


def _check(path: Path, params: Params) -> None:
    """Say which sections nothing reads; FoggyError naming all that a run of the whole experiment would lack."""
    jobs = asked.jobs(params)
    unused = checks.unused(params, jobs)
    if unused:
        print(f"{path}: note: nothing that is asked for reads {', '.join(unused)}", file=sys.stderr)
    found = checks.problems(params, jobs)
    if found:
        raise FoggyError("\n  ".join([f"{path}: a run would end on this:", *found]))


def summary(params: Params) -> list[str]:
    """What the experiment consists of, a line each."""
    lines = []
    for dataset, folder in params.scenes.roots.items():
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
