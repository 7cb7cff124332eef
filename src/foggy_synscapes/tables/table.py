"""A table before it becomes text: a frame of cells, their bold marks, what stands around them; how numbers are printed.

Numbers have one decimal, halves away from zero.
"""

import functools
from dataclasses import dataclass, field
from decimal import ROUND_HALF_UP, Decimal

import pandas as pd

MISSING = "--"  # a run that does not exist
DASH = "-"  # a class that the test set does not have
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


def round_half_up(value: float | Decimal, places: int = 1) -> Decimal:
    """Round an unrounded value once; a float counts as the decimal that it prints as, so that 0.25 gives 0.3.

    >>> round_half_up(0.25), round_half_up(1.15), round_half_up(-0.04)
    (Decimal('0.3'), Decimal('1.2'), Decimal('0.0'))
    """
    exact = value if isinstance(value, Decimal) else Decimal(repr(float(value)))
    rounded = exact.quantize(Decimal(1).scaleb(-places), ROUND_HALF_UP)
    return rounded.copy_abs() if rounded == 0 else rounded


def signed(value: float | Decimal, places: int = 1) -> str:
    """A difference with its sign; zero has none.

    >>> signed(1.25), signed(-2.0), signed(0.01)
    ('+1.3', '-2.0', '0.0')
    """
    rounded = round_half_up(value, places)
    return f"+{rounded}" if rounded > 0 else str(rounded)


def rounded(scores: pd.DataFrame) -> pd.DataFrame:
    """Unrounded numbers, or exact decimals, as they are printed; NaN where there is none."""
    return scores.map(lambda value: float(round_half_up(value)), na_action="ignore").astype(float)


def best(printed: pd.DataFrame, margins: pd.DataFrame | None = None) -> pd.DataFrame:
    """Which of a network's printed numbers are bold: the largest of each column, with all its ties, unless it is zero.

    printed : float, NaN where there is none; the index begins with the network
    margins : half the width of each number's interval, NaN where it is not known. Numbers whose interval overlaps that
        of the largest are ties, too: rows are not ranked by what chance decides
    """
    networks = printed.groupby(level=0)
    if margins is None:
        return printed.eq(networks.transform("max")) & printed.gt(0)
    # What has no interval of its own is as uncertain as the most uncertain one.
    margins = margins.fillna(margins.groupby(level=0).transform("max")).fillna(0)
    lowest = (printed - margins).where(printed.eq(networks.transform("max"))).groupby(level=0).transform("min")
    return (printed + margins).ge(lowest) & printed.gt(0)


def half_interval(std: pd.DataFrame, count: pd.Series, share: float = 0.95) -> pd.DataFrame:
    """Half the width of the interval of a mean (Student's t): so large a share of such intervals holds the true mean.

    std : standard deviation (n - 1) of the values that were averaged; count : how many they are, by row

    >>> frame = pd.DataFrame({"road": [1.0, 1.0]})
    >>> half_interval(frame, pd.Series([3, 10]))["road"].round(3).tolist()
    [2.484, 0.715]
    """
    factors = count.map(lambda n: _student(n - 1, share) / n**0.5 if n > 1 else float("nan"))
    return std.mul(factors, axis=0)


@functools.cache
def _student(freedom: int, share: float) -> float:
    """Quantile of Student's distribution, two-sided."""
    import mpmath

    def outside(t: float) -> float:
        return mpmath.betainc(freedom / 2, 0.5, 0, freedom / (freedom + t * t), regularized=True) - (1 - share)

    return float(mpmath.findroot(outside, (0.1, 1e3), solver="bisect", maxsteps=200, tol=1e-20))


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
