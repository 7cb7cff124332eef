"""subset: the lists of (image, label) that a row trains on and is validated with. Copies no image."""

import argparse

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.tables import write_csv
from foggy_synscapes.params import Params, load
from foggy_synscapes.provenance.runs import Run
from foggy_synscapes.results import roots
from foggy_synscapes.steps import job
from foggy_synscapes.subsets import KINDS
from foggy_synscapes.subsets.kind import Sources

HELP = "List the images and labels that a row of the tables trains on and is validated with."
COLUMNS = ("image", "image_sha256", "label", "label_sha256")


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this step."""
    parser.add_argument(
        "--row", required=True, help="row of the tables, e.g. FS-498: a key of the params section subset"
    )


def run(args: argparse.Namespace) -> None:
    """Run the step from the command line."""
    subset(load(args.params), args.row)


def subset(params: Params, row: str) -> None:
    """Write `train.csv` and `validation.csv` (image, its SHA-256, label map, its SHA-256) to results/subset/ROW.

    Raises
    ------
    FoggyError
        If a list asks for more frames than there are, or an image has no label map.
    """
    run = Run(job(params, "subset", row=row))
    kind, entry = params.subset.kind(row), params.subset.rows()[row]
    key = f"subset.{kind}.{row}"
    lists = KINDS[kind].lists(Sources(run.job.inputs, roots(params), params.scenes), entry, key)
    for part, asked, lines in zip(("train", "validation"), entry.counts(), lists, strict=True):
        if len(lines) != asked:
            raise FoggyError(f"{key}.{part}: {len(lines)} entries, expected {asked}")
        write_csv(run.job.output(part), COLUMNS, lines)
    run.finish()
    print(f"subset {row}: {len(lists[0])} training and {len(lists[1])} validation images")
