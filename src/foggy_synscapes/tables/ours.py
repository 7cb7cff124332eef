"""Tables of the runs made here, beside the published scores: as the paper prints them, and as one long CSV."""

import itertools
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from foggy_synscapes.datasets import DATASETS
from foggy_synscapes.labels import CLASSES
from foggy_synscapes.networks import NETWORKS
from foggy_synscapes.tables.paper import ABBREVIATIONS
from foggy_synscapes.tables.published import mean_of_classes
from foggy_synscapes.tables.table import (
    DASH,
    HEADS,
    LABELS,
    MEAN,
    MISSING,
    ROW,
    Table,
    best,
    half_interval,
    rounded,
    signed,
)

ANNOTATED, AS_PUBLISHED = "mean IoU annotated", "mean IoU as published"
MEANS = [ANNOTATED, AS_PUBLISHED]
NAMES = (*CLASSES, *MEANS)

STAND_IN = (
    "All images are the rendered stand-in, not the real datasets: compare rows with each other, not with the paper."
)


@dataclass(frozen=True)
class Results:
    """All scores of all networks and rows.

    labels : text, by `table.ROW` and `table.LABELS`
    made : by `table.ROW` and seed: whether the run exists
    scores : by `table.ROW` and score: `published` (Decimal), each seed, `ours` (mean over the seeds), `std` (n - 1)
        and `difference` (ours minus published); IoU in percent, unrounded, NaN where there is none
    """

    labels: pd.DataFrame
    made: pd.DataFrame
    scores: pd.DataFrame

    def wide(self, column: str) -> pd.DataFrame:
        """One column of the scores as a table: a line per row, a column per score."""
        return self.scores[column].unstack("score").loc[self.made.index, list(NAMES)]


def collect(
    labels: Mapping[str, Sequence[str]],
    runs: Mapping[tuple[str, str], Mapping[str, dict[str, Any] | None]],
    published: pd.DataFrame,
) -> Results:
    """Put the metrics of runs beside the published rows.

    labels : by row, what is printed for it, see `table.LABELS`
    runs : by (network, row) and seed, the metrics; None for a run that does not exist
    published : see `published.load`; rows that the paper does not have get no published numbers
    """
    means = {ANNOTATED: mean_of_classes(published, annotated=True), AS_PUBLISHED: published[MEAN]}
    printed = published[list(CLASSES)].assign(**means).to_dict("index")
    titled = {(NETWORKS[network].title, row): by_seed for (network, row), by_seed in runs.items()}
    made = pd.DataFrame.from_dict(titled, orient="index").notna().set_axis(pd.MultiIndex.from_tuples(titled, names=ROW))
    seeds = {key: pd.DataFrame({s: _scores(run) for s, run in own.items()}, NAMES) for key, own in titled.items()}
    numbers = pd.concat(seeds, names=[*ROW, "score"])
    known = [line[~np.isnan(line)].tolist() for line in numbers.to_numpy()]
    scores = numbers.assign(
        ours=[statistics.fmean(line) if line else np.nan for line in known],
        std=[statistics.stdev(line) if len(line) > 1 else np.nan for line in known],
    )
    paper = [printed.get((network, row), {}).get(name, np.nan) for network, row, name in scores.index]
    scores.insert(0, "published", pd.Series(paper, scores.index, dtype=object))
    scores["difference"] = scores["ours"] - scores["published"].astype(float)
    index = made.index
    return Results(pd.DataFrame([labels[row] for _, row in index], index, LABELS), made, scores)


def annotated_classes(documents: Sequence[dict[str, Any]]) -> list[str] | None:
    """Names of the classes that the runs' test set annotates; None without any run.

    Raises ValueError if two runs were scored against other label maps.
    """
    found = None
    for document in documents:
        names = [entry["name"] for entry in document["classes"] if entry["iou"] is not None]
        labelled = [entry["tp"] + entry["fn"] for entry in document["classes"]]
        key = names, labelled, document["images"]
        if found is not None and key != found:
            raise ValueError(
                f"scored on {key[2]} images with {len(key[0])} annotated classes and {sum(key[1])} labelled pixels, "
                f"but another run on {found[2]} with {len(found[0])} and {sum(found[1])}: not the same label maps"
            )
        found = key
    return None if found is None else found[0]


def _scores(document: dict[str, Any] | None) -> pd.Series:
    found = {} if document is None else {entry["name"]: entry["iou"] for entry in document["classes"]}
    if document is not None:
        found |= {ANNOTATED: document["mean_iou"]["annotated"], AS_PUBLISHED: document["mean_iou"]["as_published"]}
    return pd.Series(found, NAMES, dtype=float)


def tables(test_set: str, results: Results, annotated: list[str] | None, stand_in: bool, fog: str = "") -> list[Table]:
    """The table of our runs in the paper's form and, for a published test set, the tables against the paper.

    fog : what is to be said of the fog models of its rows
    """
    data = f"{DATASETS[test_set].title}{' (stand-in)' if stand_in else ''}"
    conventions = {
        ANNOTATED: "annotated" if annotated is None else f"{len(annotated)} annotated",
        AS_PUBLISHED: "19 as published",
    }
    heads = HEADS | {name: f"{MEAN}, {text}" for name, text in conventions.items()}
    published, notes = results.wide("published"), _notes(annotated, results, stand_in) + ([fog] if fog else [])
    known = {name for name in CLASSES if published[name].notna().any()}
    other = [f"The paper's column is over its own {len(known)} annotated classes."]

    def table(kind: str, caption: str, cells: pd.DataFrame, bold: pd.DataFrame, **more: Any) -> Table:
        return Table(f"{test_set}_{kind}", f"{caption} {ABBREVIATIONS}", results.labels, cells, bold, **more)

    cells, numbers = _ours(results)
    runs = results.made.sum(axis=1)
    # Of one seed there is no interval.
    margins = half_interval(results.wide("std"), runs) if runs.max() > 1 else numbers * 0
    caption = f"Results on {data} of the runs made here: IoU in percent."
    ours = table("ours", caption, cells.rename(columns=heads), best(numbers, margins), notes=notes)
    if published.isna().all(axis=None):
        return [ours]
    notes = notes + (other if annotated is not None and known != set(annotated) else [])
    paper, differences = rounded(published[MEANS]), _differences(results)
    texts = {
        "paper": paper.map("{:.1f}".format).where(paper.notna(), MISSING),
        "ours": cells,
        "difference": differences.replace(DASH, MISSING),
    }
    values = {"paper": paper, "ours": numbers, "difference": paper * np.nan}
    widths = {"paper": paper * 0, "ours": margins, "difference": paper * np.nan}
    shown, marks, intervals = (
        pd.DataFrame({(text, head): beside[head][name] for name, text in conventions.items() for head in beside})
        for beside in (texts, values, widths)
    )
    caption = f"Mean IoU on {data} in percent: the paper, the runs made here, and their difference."
    means = table("means", caption, shown, best(marks, intervals), notes=notes, upright=True)
    caption = f"Difference on {data}, the runs made here minus the paper: IoU in points of percent."
    none = pd.DataFrame(False, differences.index, differences.columns)
    return [ours, means, table("difference", caption, differences.rename(columns=heads), none, notes=notes)]


def long_csv(test_set: str, results: Results) -> str:
    """One line per network, row and score, unrounded; see `docs/tables.md`."""
    made = results.made.loc[results.scores.index.droplevel("score")].set_axis(results.scores.index)
    scores = results.scores.astype(object)
    for column in (*made.columns, "ours"):
        here = made[column] if column in made else made.any(axis=1)
        scores[column] = scores[column].where(scores[column].notna(), DASH).where(here, MISSING)
    scores["difference"] = scores["difference"].where(made.any(axis=1), MISSING)
    # Of one seed there is no deviation.
    numbers = scores[["published", "ours", "std", "difference", *made.columns]].reset_index("score")
    lines = results.labels.join(numbers.rename(columns={seed: f"seed_{seed}" for seed in made}), how="right")
    lines = lines.reset_index()
    lines.insert(0, "test_set", test_set)
    return lines.to_csv(index=False, lineterminator="\n")


def means(results: Results) -> dict[str, dict[str, float]]:
    """Mean IoU over the annotated classes by network and row, where it was run: what `dvc metrics` compares."""
    found: dict[str, dict[str, float]] = {}
    for (network, row), mean in results.wide("ours")[ANNOTATED].dropna().items():
        found.setdefault(network, {})[row] = mean
    return found


def _ours(results: Results) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Our scores as printed, and as numbers: NaN where there are none."""
    numbers, spread = rounded(results.wide("ours")), rounded(results.wide("std")[MEANS])
    cells = numbers.map("{:.1f}".format).where(numbers.notna(), DASH)
    cells[MEANS] = cells[MEANS].where(spread.isna(), cells[MEANS] + " ± " + spread.map("{:.1f}".format))
    return cells.where(results.made.any(axis=1), MISSING, axis=0), numbers


def _differences(results: Results) -> pd.DataFrame:
    """Ours minus published as printed; a class that our ground truth does not hold has a dash."""
    differences, undefined = results.wide("difference"), results.wide("ours").isna()
    cells = differences.map(signed, na_action="ignore").astype(object)
    return cells.where(differences.notna(), MISSING).mask(undefined.mul(results.made.any(axis=1), axis=0), DASH)


def _notes(annotated: list[str] | None, results: Results, stand_in: bool) -> list[str]:
    made, seeds = results.made, list(results.made.columns)
    notes = [STAND_IN] if stand_in else []
    if annotated is not None:
        absent = [name for name in CLASSES if name not in annotated]
        without = f" (not {', '.join(absent)})" if absent else ""
        notes.append(
            f"{len(annotated)} annotated: mean over the classes of this ground truth{without}; "
            "19 as published: absent classes count as 0."
        )
    if len(seeds) > 1:
        notes.append(f"Mean over seeds {', '.join(seeds)}; ± is their standard deviation. {_order(results)}")
    if not made.any(axis=1).all():
        notes.append(f"{MISSING}: not run.")
    partial = made[made.any(axis=1) & ~made.all(axis=1)]
    if not partial.empty:
        names = [f"{' '.join(key)} ({count} of {len(seeds)})" for key, count in partial.sum(axis=1).items()]
        notes.append(f"Fewer seeds than asked for: {', '.join(names)}.")
    return notes


def _order(results: Results) -> str:
    """How far the order of the rows depends on the seed, in words."""
    means = results.scores.xs(ANNOTATED, level="score")[list(results.made)]
    pairs, changed = 0, 0
    for _, rows in means.groupby(level=0):
        for one, other in itertools.combinations(rows.to_numpy(), 2):
            differences = (one - other)[~np.isnan(one - other)]
            pairs += differences.size > 1
            changed += differences.size > 1 and differences.min() < 0 < differences.max()
    bold = "Bold: not worse than the best beyond the 95 % intervals of their means."
    return (
        f"{bold} {changed} of {pairs} pairs of rows of a network change their order with the seed." if pairs else bold
    )
