"""The scores of the runs made here, beside the published ones."""

import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from foggy_synscapes.labels import CLASSES
from foggy_synscapes.networks import NETWORKS
from foggy_synscapes.tables.published import mean_of_classes
from foggy_synscapes.tables.table import LABELS, MEAN, ROW

ANNOTATED, AS_PUBLISHED = "mean IoU annotated", "mean IoU as published"
MEANS = [ANNOTATED, AS_PUBLISHED]
NAMES = (*CLASSES, *MEANS)


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


def images_text(published: int | None, here: int | None) -> str:
    """A number of images as printed, and how it was scaled; empty where there is none.

    >>> images_text(24500, 600), images_text(498, 498), images_text(None, 400), images_text(498, None)
    ('24,500 -> 600 here', '498', '400 here', '498')
    """
    if here is None:
        return "" if published is None else f"{published:,}"
    if published is None:
        return f"{here:,} here"
    return f"{here:,}" if here == published else f"{published:,} -> {here:,} here"


def _defined(score: float | None) -> float:
    return math.nan if score is None else score


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
    index = pd.MultiIndex.from_tuples(list(titled), names=ROW)
    lines = []
    for key, by_seed in titled.items():
        ours = {seed: _scores(document) for seed, document in by_seed.items()}
        for name in NAMES:
            line = {seed: _defined(values.get(name)) for seed, values in ours.items()}
            known = [value for value in line.values() if not math.isnan(value)]
            line |= {
                "ours": statistics.fmean(known) if known else math.nan,
                "std": statistics.stdev(known) if len(known) > 1 else math.nan,
            }
            lines.append([*key, name, printed.get(key, {}).get(name, math.nan), *line.values()])
    seeds = list(next(iter(titled.values())))
    made = [[document is not None for document in by_seed.values()] for by_seed in titled.values()]
    scores = pd.DataFrame(lines, columns=[*ROW, "score", "published", *seeds, "ours", "std"])
    scores["published"] = scores["published"].astype(object)
    scores["difference"] = scores["ours"] - scores["published"].astype(float)
    return Results(
        labels=pd.DataFrame([labels[row] for _, row in index], index=index, columns=LABELS),
        made=pd.DataFrame(made, index=index, columns=seeds),
        scores=scores.set_index([*ROW, "score"]),
    )


def annotated_classes(documents: Sequence[dict[str, Any]]) -> list[str] | None:
    """Names of the classes that the runs' test set annotates; None without any run.

    Raises
    ------
    ValueError
        If two runs were scored against other label maps.
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


def _scores(document: dict[str, Any] | None) -> dict[str, float | None]:
    if document is None:
        return {}
    means = document["mean_iou"]
    classes = {entry["name"]: entry["iou"] for entry in document["classes"]}
    return {**classes, ANNOTATED: means["annotated"], AS_PUBLISHED: means["as_published"]}
