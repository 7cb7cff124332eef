"""Scores from a confusion matrix (C, C + 1): see `confusion.fold` for its rows and columns.

Scores are fractions in [0, 1], NaN where they are undefined. The matrix is summed over the whole test set
first: a mean over images of their IoU is another, smaller-object-blind number and is not given here.
"""

from collections.abc import Mapping, Sequence
from functools import reduce
from operator import add

import numpy as np


def true_positives(matrix: np.ndarray) -> np.ndarray:
    """True positives: pixels of each class that are predicted as it, int64 (C,)."""
    return np.diagonal(matrix).copy()


def false_positives(matrix: np.ndarray) -> np.ndarray:
    """False positives: pixels of other classes that are predicted as each class, int64 (C,)."""
    return matrix[:, :-1].sum(axis=0) - true_positives(matrix)


def false_negatives(matrix: np.ndarray) -> np.ndarray:
    """False negatives: pixels of each class that are predicted as anything else, void too, int64 (C,)."""
    return matrix.sum(axis=1) - true_positives(matrix)


def annotated(matrix: np.ndarray) -> np.ndarray:
    """Whether the ground truth holds any pixel of each class, bool (C,)."""
    return np.asarray(matrix.any(axis=1))


def iou(matrix: np.ndarray) -> np.ndarray:
    """Intersection over union of each class, TP / (TP + FP + FN), float64 (C,).

    NaN where the ground truth does not hold the class: its union is then made of false alarms alone, and a
    single one of them would decide between "undefined" and 0.

    >>> iou(np.array([[3, 1, 0], [0, 2, 2]])).tolist()
    [0.75, 0.4]
    """
    return np.where(annotated(matrix), iou_as_cityscapes(matrix), np.nan)


def iou_as_cityscapes(matrix: np.ndarray) -> np.ndarray:
    """Intersection over union as the Cityscapes scripts have it: 0 for a class that is only falsely predicted.

    NaN only where a class is neither labelled nor predicted.
    """
    return _ratio(true_positives(matrix), matrix.sum(axis=1) + false_positives(matrix))


def mean_annotated(scores: Sequence[float] | np.ndarray) -> float:
    """Mean over the scores that are defined; NaN if none is.

    >>> mean_annotated([0.5, float("nan"), 1.0])
    0.75
    """
    defined = [float(score) for score in scores if not np.isnan(score)]
    # Added one by one in class order, as other scorers do: numpy and newer Pythons sum in other orders.
    return reduce(add, defined, 0.0) / len(defined) if defined else float("nan")


def mean_as_published(scores: Sequence[float] | np.ndarray) -> float:
    """Mean over all classes, an undefined score counting as 0: the printed means of Tables I and II.

    >>> mean_as_published([0.5, float("nan"), 1.0])
    0.5
    """
    return reduce(add, [0.0 if np.isnan(score) else float(score) for score in scores], 0.0) / len(scores)


def pixel_accuracy(matrix: np.ndarray) -> float:
    """Share of the labelled pixels that are predicted rightly; NaN if none is labelled."""
    return float(_ratio(true_positives(matrix).sum(), matrix.sum()))


def frequency_weighted_iou(matrix: np.ndarray) -> float:
    """Mean of the IoU of the labelled classes, each weighted by its share of the labelled pixels."""
    present = annotated(matrix)
    weights = _ratio(matrix.sum(axis=1), matrix.sum())
    return float(np.sum(weights[present] * iou(matrix)[present])) if present.any() else float("nan")


def category_iou(matrix: np.ndarray, categories: Mapping[str, Sequence[int]]) -> dict[str, float]:
    """Intersection over union of groups of class indices, as the Cityscapes scripts have it.

    A confusion within a category counts as a hit, a prediction of no class as a miss. NaN where a category
    is neither labelled nor predicted.
    """
    scores = {}
    for name, members in categories.items():
        index = list(members)
        hit = matrix[np.ix_(index, index)].sum()
        labelled, predicted = matrix[index].sum(), matrix[:, index].sum()
        scores[name] = float(_ratio(hit, labelled + predicted - hit))
    return scores


def _ratio(part: np.ndarray, whole: np.ndarray) -> np.ndarray:
    return np.where(whole > 0, part / np.where(whole > 0, whole, 1), np.nan)
