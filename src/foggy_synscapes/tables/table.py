"""A table before it becomes text: a frame of cells, their bold marks, and what stands around them."""

from dataclasses import dataclass, field

import pandas as pd

from foggy_synscapes.tables.numbers import round_half_up

# The paper's heads; other classes are headed by their names.
HEADS = {"traffic light": "tr.light", "traffic sign": "tr.sign"}
MEAN = "mean IoU"
ROW = ["network", "row"]
LABELS = ["training", "fine_tuning", "images"]


@dataclass(frozen=True)
class Table:
    """A whole table; its frames share the index `ROW`, and a network's rows make a block.

    labels : text, by `LABELS`: what was trained on, what it was fine-tuned on, with how many images
    cells : text, by head or by (group of heads, head)
    bold : whether each cell is bold
    upright : heads are printed level, not turned by 90 degrees
    """

    name: str
    caption: str
    labels: pd.DataFrame
    cells: pd.DataFrame
    bold: pd.DataFrame
    notes: list[str] = field(default_factory=list)
    upright: bool = False

    @property
    def heads(self) -> list[tuple[str, str]]:
        """Group and head of each column; the group is empty where there are none."""
        return [head if isinstance(head, tuple) else ("", head) for head in self.cells.columns]


def rounded(scores: pd.DataFrame) -> pd.DataFrame:
    """Unrounded numbers, or exact decimals, as they are printed; NaN where there is none."""
    return scores.map(lambda value: float(round_half_up(value)), na_action="ignore").astype(float)


def best(printed: pd.DataFrame) -> pd.DataFrame:
    """Which of a network's printed numbers are bold: the largest of each column, with all its ties, unless it is zero.

    printed : float, NaN where there is none; the index begins with the network
    """
    return printed.eq(printed.groupby(level=0).transform("max")) & printed.gt(0)
