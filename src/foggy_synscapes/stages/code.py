"""code: what counts of the code of each job, as files that DVC compares."""

import argparse
from pathlib import Path

from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.jobs import Job
from foggy_synscapes.params import Params, load
from foggy_synscapes.provenance.runs import code_of, code_text
from foggy_synscapes.results import CODE
from foggy_synscapes.steps import code_file, steps

HELP = (
    "Write what counts of the code of each job: digests of the syntax trees of its modules, versions of its libraries. "
    "DVC compares these files, so that an edited comment runs nothing; Snakemake computes the same by itself."
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """This command has no options of its own."""


def run(args: argparse.Namespace) -> None:
    """Run the command."""
    count = code(load(args.params))
    print(f"code: {count} files in {CODE}")


def code(params: Params) -> int:
    """Write a file for each kind of job and each entry that it may use, remove all others, and count them."""
    written: set[Path] = set()
    for step in steps():
        for values in step.all_values(params) if step.default else ():
            path = Path(code_file(step, values))
            if path not in written:
                write_text(path, code_text(*code_of(Job(step, params, values))))
                written.add(path)
    for path in Path(CODE).rglob("*"):
        if path.is_file() and path not in written:
            path.unlink()
    return len(written)
