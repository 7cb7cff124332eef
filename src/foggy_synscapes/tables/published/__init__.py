"""Tables I and II of the paper as data: one CSV per test set, one line per printed row.

`label_line` and `value_line` are the lines of the paper's LaTeX source that print the row's labels and its numbers.
Numbers stand as they are printed, `-` where the paper prints a dash.
Source: Hahner, Dai, Sakaridis, Zaech and Van Gool, Semantic Understanding of Foggy Scenes with Purely Synthetic Data,
ITSC 2019.
"""

from decimal import Decimal
from importlib import resources

import numpy as np
import pandas as pd

from foggy_synscapes.labels import CLASSES
from foggy_synscapes.tables.table import MEAN, ROW

TEST_SETS = sorted(
    file.name.removesuffix(".csv") for file in resources.files(__package__).iterdir() if file.name.endswith(".csv")
)


def load(test_set: str) -> pd.DataFrame:
    """Rows of one table by network and row, in printed order; none for a test set that the paper does not have.

    Labels are text. Classes and `MEAN` are IoU in percent as Decimal, NaN where a dash stands.

    >>> [str(mean) for mean in load("foggy_driving").xs("FC-FS-498", level="row")["mean IoU"]]
    ['50.7', '35.2']
    """
    known = test_set in TEST_SETS
    with resources.files(__package__).joinpath(f"{test_set if known else TEST_SETS[0]}.csv").open() as file:
        rows = pd.read_csv(file, dtype=object, keep_default_na=False).set_index(ROW)
    numbers = [*CLASSES, MEAN]
    rows[numbers] = rows[numbers].map(lambda text: np.nan if text == "-" else Decimal(text)).astype(object)
    return rows if known else rows.iloc[:0]


def mean_of_classes(rows: pd.DataFrame, annotated: bool) -> pd.Series:
    """Mean of each row's printed classes, as Decimal: over those with a number, or over all, a dash counting as 0."""
    known = [iou.dropna() for _, iou in rows[list(CLASSES)].iterrows()]
    means = [sum(iou) / (len(iou) if annotated else len(CLASSES)) for iou in known]
    return pd.Series(means, index=rows.index, dtype=object)
