"""Tables I and II of the paper as data: one CSV per test set, one line per printed row.

`label_line` and `value_line` are the lines of the paper's LaTeX source that print the row's labels and its numbers.
Numbers stand as they are printed, `-` where the paper prints a dash.
Source: Hahner, Dai, Sakaridis, Zaech and Van Gool, Semantic Understanding of Foggy Scenes with Purely Synthetic Data,
ITSC 2019.
"""

import csv
from dataclasses import dataclass
from decimal import Decimal
from importlib import resources

from foggy_synscapes.labels import CLASSES

TEST_SETS = ("foggy_driving", "foggy_zurich")
MEAN = "mean IoU"


@dataclass(frozen=True)
class PublishedRow:
    """One printed row: labels, IoU in percent by class (None where a dash stands), and the printed mean."""

    network: str
    row: str
    training: str
    fine_tuning: str
    images: int | None
    label_line: int
    value_line: int
    iou: dict[str, Decimal | None]
    mean: Decimal

    def mean_of_classes(self, annotated: bool) -> Decimal:
        """Mean of the printed classes: over those with a number, or over all 19, a dash counting as 0."""
        known = [value for value in self.iou.values() if value is not None]
        return sum(known) / (len(known) if annotated else len(self.iou))


def load(test_set: str) -> list[PublishedRow]:
    """Rows of one table, in printed order; an empty list for a test set that the paper does not have.

    >>> [row.mean for row in load("foggy_zurich") if row.row == "FC-FS-498"]
    [Decimal('41.4'), Decimal('30.9')]
    """
    if test_set not in TEST_SETS:
        return []
    text = resources.files(__package__).joinpath(f"{test_set}.csv").read_text(encoding="utf-8")
    return [_row(cells) for cells in csv.DictReader(text.splitlines())]


def _row(cells: dict[str, str]) -> PublishedRow:
    return PublishedRow(
        network=cells["network"],
        row=cells["row"],
        training=cells["training"],
        fine_tuning=cells["fine_tuning"],
        images=int(cells["images"]) if cells["images"] else None,
        label_line=int(cells["label_line"]),
        value_line=int(cells["value_line"]),
        iou={name: None if cells[name] == "-" else Decimal(cells[name]) for name in CLASSES},
        mean=Decimal(cells[MEAN]),
    )
