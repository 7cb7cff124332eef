"""How certain a difference of mean IoU is: a paired bootstrap over the images of a test set.

Images are drawn again with replacement, as many as there are, the same for both of what is compared; the counts of the
drawn ones are summed before IoU is formed, as for the test set itself. Source: Efron and Tibshirani, An Introduction to
the Bootstrap, 1993, chapters 13 and 16.
"""

import math

import numpy as np

SHARE = 0.95
"""Of the resampled differences that an interval holds."""
ROUNDS = 2000
"""Resampled test sets: with another seed the ends of an interval move by 1 to 2 % of its width."""


def mean_iou(matrices: np.ndarray) -> np.ndarray:
    """Mean IoU of each matrix over the classes that it labels, in percent: (..., C, C + 1) -> float64 (...).

    >>> mean_iou(np.array([[[3, 1, 0], [0, 2, 2]]])).round(1).tolist()
    [57.5]
    """
    right, labelled = np.diagonal(matrices, axis1=-2, axis2=-1), matrices.sum(axis=-1)
    union = labelled + matrices[..., :-1].sum(axis=-2) - right
    shares = np.where(labelled > 0, right / np.maximum(union, 1), np.nan)
    return 100 * np.nanmean(shares, axis=-1)


def interval(
    reference: np.ndarray, other: np.ndarray, rounds: int = ROUNDS, seed: int = 0
) -> tuple[float, float] | None:
    """Ends of the 95 % interval of other minus reference, in points of mean IoU; None of a single image.

    reference, other : int64 (N, C, C + 1), the confusion matrix of each image (see `confusion.fold`). What belongs
    together, such as one scene at several densities of fog, is to be one image here
    """
    if reference.shape != other.shape:
        raise ValueError(f"other: shape {other.shape}, but the reference has {reference.shape}")
    count = len(reference)
    if count < 2:
        return None
    drawn = np.random.default_rng(seed).multinomial(count, [1 / count] * count, size=rounds)
    found = []
    for matrices in (reference, other):
        # In float64 sums are exact up to 2^53 pixels.
        sums = drawn.astype(float) @ matrices.reshape(count, -1).astype(float)
        found.append(mean_iou(sums.reshape(rounds, *matrices.shape[1:])))
    low, high = np.quantile(found[1] - found[0], [(1 - SHARE) / 2, (1 + SHARE) / 2])
    return float(low), float(high)


def in_words(change: float, ends: tuple[float, float] | None) -> str:
    """What an interval allows to say of a change of mean IoU, in points.

    >>> in_words(-0.1, (-0.4, 0.2)), in_words(-2.0, (-3.04, -1.0)), in_words(0.3, None)
    ('no difference found above 0.40 points', 'loses 1.00 to 3.04 points', 'of one image there is no interval')
    >>> in_words(0.0, (0.0, 0.0))
    'no difference at all'
    """
    if ends is None:
        return "of one image there is no interval"
    low, high = ends
    if low == high == 0:
        return "no difference at all"
    if low <= 0 <= high:
        return f"no difference found above {rounded_up(max(-low, high)):.2f} points"
    small, large = sorted((abs(low), abs(high)))
    return f"{'loses' if change < 0 else 'gains'} {small:.2f} to {large:.2f} points"


def rounded_up(points: float) -> float:
    """A bound as it is printed, with two decimals: not below what it bounds."""
    return math.ceil(points * 100 - 1e-9) / 100
