"""The scores of the runs made here, beside the published ones."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

from foggy_synscapes.labels import CLASSES
from foggy_synscapes.tables.numbers import count
from foggy_synscapes.tables.published import PublishedRow

NETWORKS = {"refinenet": "RefineNet", "bisenet": "BiSeNet"}
ANNOTATED, AS_PUBLISHED = "mean IoU annotated", "mean IoU as published"
NAMES = (*CLASSES, ANNOTATED, AS_PUBLISHED)


@dataclass(frozen=True)
class RowLabel:
    """A printed row: its key, what is printed for it, the published number of images and the number used here."""

    row: str
    training: str
    fine_tuning: str
    images: int | None
    here: int | None

    @property
    def images_text(self) -> str:
        """The number of images, and how it was scaled: "24,500 -> 600 here"."""
        if self.here is None:
            return "" if self.images is None else count(self.images)
        if self.images is None:
            return f"{count(self.here)} here"
        return count(self.here) if self.here == self.images else f"{count(self.images)} -> {count(self.here)} here"


@dataclass(frozen=True)
class Score:
    """One number: as published, and in each run made here; None where it is not there or undefined."""

    published: Decimal | None
    runs: tuple[float | None, ...]

    @property
    def mean(self) -> float | None:
        """Mean over the runs in which it is defined."""
        known = [value for value in self.runs if value is not None]
        return math.fsum(known) / len(known) if known else None

    @property
    def spread(self) -> float | None:
        """Standard deviation over the runs (n - 1), None for fewer than two."""
        known = [value for value in self.runs if value is not None]
        if len(known) < 2:
            return None
        mean = math.fsum(known) / len(known)
        return math.sqrt(math.fsum((value - mean) ** 2 for value in known) / (len(known) - 1))

    @property
    def difference(self) -> float | None:
        """Ours minus published."""
        return None if self.mean is None or self.published is None else self.mean - float(self.published)


@dataclass(frozen=True)
class Result:
    """All scores of one network and row; `made` says for each seed whether its run exists."""

    network: str
    label: RowLabel
    made: tuple[bool, ...]
    scores: dict[str, Score]


def collect(
    networks: Sequence[str],
    labels: Sequence[RowLabel],
    runs: Mapping[tuple[str, str], Sequence[dict[str, Any] | None]],
    published: Sequence[PublishedRow],
) -> list[Result]:
    """Put the metrics of runs, by (network, row) and then by seed, beside the published rows.

    A run that does not exist is None. Rows that the paper does not have get no published numbers.
    """
    printed = {(row.network, row.row): _published(row) for row in published}
    results = []
    for network in networks:
        name = NETWORKS.get(network, network)
        for label in labels:
            documents = runs[network, label.row]
            known = printed.get((name, label.row), {})
            ours = [_ours(document) for document in documents if document is not None]
            scores = {key: Score(known.get(key), tuple(values[key] for values in ours)) for key in NAMES}
            results.append(Result(name, label, tuple(document is not None for document in documents), scores))
    return results


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


def _published(row: PublishedRow) -> dict[str, Decimal | None]:
    return {**row.iou, ANNOTATED: row.mean_of_classes(annotated=True), AS_PUBLISHED: row.mean}


def _ours(document: dict[str, Any]) -> dict[str, float | None]:
    means = document["mean_iou"]
    classes = {entry["name"]: entry["iou"] for entry in document["classes"]}
    return {**classes, ANNOTATED: means["annotated"], AS_PUBLISHED: means["as_published"]}
