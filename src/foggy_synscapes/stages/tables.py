"""tables: the mIoU tables of the runs made here, and those of the paper from their published numbers."""

import argparse
import json
from pathlib import Path
from typing import Any

from foggy_synscapes.datasets.scores import read_scores, scores_path
from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.tables import write_csv
from foggy_synscapes.params import Params, load
from foggy_synscapes.provenance.recorded import recorded
from foggy_synscapes.provenance.runs import checked_inputs, write_run
from foggy_synscapes.tables import html, latex, markdown
from foggy_synscapes.tables.ours import TITLES, grids, long_columns, means
from foggy_synscapes.tables.paper import published_columns, published_grid
from foggy_synscapes.tables.published import TEST_SETS as PUBLISHED
from foggy_synscapes.tables.published import load as load_published
from foggy_synscapes.tables.results import RowLabel, annotated_classes, collect

HELP = "Make the tables of mean IoU (percent): CSV, LaTeX, Markdown and HTML."
FOLDER = Path("results/tables")
RUNS = ("train.networks", "train.seeds", "train.from_weights", "train.from_baseline")
READ = ("tables", "subset", "scenes.roots", *RUNS)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this step."""
    parser.add_argument("--test-set", choices=sorted(TITLES), help="make the tables of the runs on this test set")
    parser.add_argument(
        "--published", action="store_true", help="make both tables of the paper from its numbers instead"
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="with --published: folder to write to")


def run(args: argparse.Namespace) -> None:
    """Run the step from the command line."""
    if args.published:
        if args.test_set or not args.out:
            raise UsageError("--published makes both tables of the paper: give --out DIR and no --test-set")
        published(args.out)
    elif args.test_set and not args.out:
        tables(load(args.params), args.test_set)
    else:
        raise UsageError("give --test-set, or --published and --out DIR")


def published(out: Path) -> None:
    """Write `foggy_driving.tex`, `.csv` and `.md`, and those of `foggy_zurich`: Tables I and II of the paper."""
    for test_set in PUBLISHED:
        rows = load_published(test_set)
        grid = published_grid(test_set, rows)
        write_csv(out / f"{test_set}.csv", *published_columns(rows))
        write_text(out / f"{test_set}.tex", latex.document([grid], "Made by foggy tables --published."))
        write_text(out / f"{test_set}.md", markdown.table(grid))
        print(f"{out / test_set}.tex, .csv and .md: {len(rows)} published rows")


def tables(params: Params, test_set: str) -> None:
    """Write results/tables/TEST_SET.csv, .tex, .md, .html and .json from the metrics of all runs that exist.

    Raises
    ------
    FoggyError
        If a metrics file is damaged or of other classes, or two runs were scored against other label maps.
    """
    lists, rows = params.subset.rows(), [entry.row for entry in params.tables.rows]
    # The baseline is trained, not fine-tuned: its row names no number of images, as in the paper.
    used = {row: lists[row].train if row in lists and row not in params.train.from_weights else None for row in rows}
    labels = [RowLabel(r.row, r.training, r.fine_tuning, r.images, used[r.row]) for r in params.tables.rows]
    networks, seeds = list(params.train.networks), list(params.train.seeds)
    # Metrics of a row that these params do not train may lie there from others: they are not of this experiment.
    trained = [*params.train.from_weights, *params.train.from_baseline]
    runs: dict[tuple[str, str], list[dict[str, Any] | None]] = {}
    documents: list[dict[str, Any]] = []
    inputs: dict[str, str] = {}
    for network in networks:
        for label in labels:
            paths = [scores_path(test_set, network, label.row, seed) for seed in seeds]
            inputs.update(checked_inputs(path for path in paths if label.row in trained and path.is_file()))
            runs[network, label.row] = [read_scores(path) if label.row in trained else None for path in paths]
            for path, document in zip(paths, runs[network, label.row], strict=True):
                if document is not None:
                    documents.append(document)
                    _same_labels(documents, path)
    results = collect(networks, labels, runs, load_published(test_set))
    outputs = [FOLDER / f"{test_set}.{ending}" for ending in ("csv", "tex", "md", "html", "json")]
    made = grids(test_set, results, annotated_classes(documents), seeds, params.stand_in)
    write_csv(outputs[0], *long_columns(test_set, results, seeds))
    write_text(outputs[1], latex.document(made, f"Made by foggy tables --test-set {test_set}."))
    write_text(outputs[2], "\n".join(markdown.table(grid) for grid in made))
    write_text(outputs[3], html.document(made, TITLES[test_set]))
    write_text(outputs[4], json.dumps(means(results), indent=1) + "\n")
    write_run(
        FOLDER / f"{test_set}.run.json",
        command=["foggy", "tables", "--test-set", test_set],
        params=recorded(params, *READ),
        inputs=inputs,
        outputs=outputs,
    )
    print(f"tables {test_set}: {len(documents)} of {len(networks) * len(labels) * len(seeds)} runs; see {outputs[2]}")


def _same_labels(documents: list[dict[str, Any]], path: Path) -> None:
    try:
        annotated_classes([documents[0], documents[-1]])
    except ValueError as error:
        raise FoggyError(f"{path}: {error}. Evaluate all rows again.") from error
