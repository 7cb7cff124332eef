"""tables: the mIoU tables of the runs made here, and those of the paper from their published numbers."""

import argparse
import json
from pathlib import Path
from typing import Any

from foggy_synscapes.datasets import DATASETS, test_sets
from foggy_synscapes.depth.quality import SUMS
from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.files import named
from foggy_synscapes.io.tables import read_csv
from foggy_synscapes.params import Params, load
from foggy_synscapes.provenance.runs import Run
from foggy_synscapes.scoring.metrics import read_scores
from foggy_synscapes.steps import job
from foggy_synscapes.tables import depth_quality, formats, ours
from foggy_synscapes.tables.ours import annotated_classes, collect
from foggy_synscapes.tables.paper import published_csv, published_table
from foggy_synscapes.tables.published import TEST_SETS as PUBLISHED
from foggy_synscapes.tables.published import load as load_published
from foggy_synscapes.tables.table import images_text

HELP = "Make the tables of mean IoU (percent): CSV, LaTeX, Markdown and HTML."


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this step."""
    parser.add_argument("--test-set", metavar="NAME", help="make the tables of the runs on this test set")
    parser.add_argument(
        "--paper",
        action="store_true",
        help="only the rows that the paper has, below results/tables/paper",
    )
    parser.add_argument(
        "--published", action="store_true", help="make both tables of the paper from its numbers instead"
    )
    parser.add_argument("--depth", action="store_true", help="make the table of errors of completed depth instead")
    parser.add_argument("--out", type=Path, metavar="DIR", help="with --published: folder to write to")


def run(args: argparse.Namespace) -> None:
    """Run the step from the command line."""
    if args.published:
        if args.test_set or args.paper or not args.out:
            raise UsageError("--published makes both tables of the paper: give --out DIR, and no --test-set or --paper")
        published(args.out)
    elif args.depth:
        if args.test_set or args.paper or args.out:
            raise UsageError("--depth makes the one table of completed depth: give no other option")
        depth(load(args.params))
    elif args.test_set and not args.out:
        params = load(args.params)
        if args.test_set not in (known := test_sets()):
            raise UsageError(f"--test-set {args.test_set}: there are {', '.join(known)}")
        if args.paper and args.test_set not in PUBLISHED:
            raise UsageError(f"--paper: has tables of {', '.join(PUBLISHED)}, none of {args.test_set}")
        tables(params, args.test_set, args.paper)
    else:
        raise UsageError("give --test-set, or --published and --out DIR")


def published(out: Path) -> None:
    """Write TEST_SET.tex, .csv and .md of each published test set: Tables I and II of the paper."""
    for test_set in PUBLISHED:
        rows = load_published(test_set)
        table = published_table(test_set, rows)
        write_text(out / f"{test_set}.csv", published_csv(rows))
        write_text(out / f"{test_set}.tex", formats.latex([table], "Made by foggy tables --published."))
        write_text(out / f"{test_set}.md", formats.markdown([table]))
        print(f"{out / test_set}.tex, .csv and .md: {len(rows)} published rows")


def depth(params: Params) -> None:
    """Write results/tables/depth_quality.csv and .md from the errors of all shards.

    Raises FoggyError if the params ask for no such table, or a file is missing or damaged.
    """
    if params.stereo is None:
        raise UsageError("--depth: there is no section stereo in the params")
    run = Run(job(params, "tables_depth"))
    columns, lines = ("class", "distance", *SUMS), []
    for beta in params.fog.betas:
        own = [run.job.one("errors", beta=beta, shard=shard) for shard in params.scenes.shards]
        with named(own[0].parent, "folder of tables of errors"):
            lines += depth_quality.collect(beta, [line for path in own for line in read_csv(path, columns)])
    run.write(csv=depth_quality.csv_text(lines), md=depth_quality.markdown(lines, params.stand_in))
    run.finish()
    print(f"tables: errors of completed depth; see {run.job.output('md')}")


def tables(params: Params, test_set: str, paper: bool = False) -> None:
    """Write results/tables/TEST_SET.csv, .tex, .md, .html and .json from the metrics of all runs that exist.

    paper : only of the networks and rows of which the paper prints numbers, to results/tables/paper

    Raises
    ------
    FoggyError
        If a metrics file is damaged or of other classes, or two runs were scored against other label maps.
    """
    this = job(params, "tables_paper" if paper else "tables", test_set=test_set)
    only = this.step.only(params) if this.step.only else {}
    lists, rows = params.subset.rows(), only.get("row", [entry.row for entry in params.tables.rows])
    # The baseline is trained, not fine-tuned: its row names no number of images, as in the paper.
    used = {row: lists[row].train if row in lists and row not in params.train.from_weights else None for row in rows}
    printed = [entry for entry in params.tables.rows if entry.row in rows]
    labels = {r.row: (r.training, r.fine_tuning, images_text(r.images, used[r.row])) for r in printed}
    networks, seeds = list(only.get("network", params.train.networks)), list(params.train.seeds)
    # Metrics of a row that these params do not train may lie there from others: they are not of this experiment.
    trained = [*params.train.from_weights, *params.train.from_baseline]
    runs: dict[tuple[str, str], dict[str, dict[str, Any] | None]] = {}
    documents: list[dict[str, Any]] = []
    run = Run(this, [path for path in this.read() if path.is_file()])
    for network in networks:
        for row in rows:
            paths = {seed: this.one("metrics", network=network, row=row, seed=seed) for seed in seeds}
            runs[network, row] = {seed: read_scores(path) if row in trained else None for seed, path in paths.items()}
            for path, document in zip(paths.values(), runs[network, row].values(), strict=True):
                if document is not None:
                    documents.append(document)
                    _same_labels(documents, path)
    results = collect(labels, runs, load_published(test_set))
    made = ours.tables(test_set, results, annotated_classes(documents), params.stand_in, params.fog_models())
    run.write(
        csv=ours.long_csv(test_set, results),
        tex=formats.latex(made, f"Made by {' '.join(this.command)}."),
        md=formats.markdown(made),
        html=formats.html(made, DATASETS[test_set].title),
        json=json.dumps(ours.means(results), indent=1) + "\n",
    )
    run.finish()
    count = len(networks) * len(labels) * len(seeds)
    print(f"tables {test_set}: {len(documents)} of {count} runs; see {this.output('md')}")


def _same_labels(documents: list[dict[str, Any]], path: Path) -> None:
    try:
        annotated_classes([documents[0], documents[-1]])
    except ValueError as error:
        raise FoggyError(f"{path}: {error}. Evaluate all rows again.") from error
