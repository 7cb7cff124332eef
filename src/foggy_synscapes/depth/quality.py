"""How far depth, and the fog that is made of it, are from the truth: by class and by distance."""

from collections.abc import Sequence

import numpy as np

from foggy_synscapes.labels import CLASSES, IGNORE

EDGES = (0.0, 25.0, 50.0, 100.0, 200.0, np.inf)
"""Metres between which distances are counted together; beyond the last but one lies what fog hides."""
FARTHEST = 1000.0
"""Metres beyond which a depth counts as this: a sky at 8 km is right wherever it is far."""
SUMS = ("pixels", "depth", "relative", "transmittance", "levels")
"""What is summed: pixels, and over them |error of depth| in metres, the same by true depth, |error of t|, and |error of
grey levels|, mean of the three colours."""
GROUPS = ("0 to 25 m", "25 to 50 m", "50 to 100 m", "100 to 200 m", "beyond 200 m")
"""The distances between `EDGES`."""


def sums(
    labels: np.ndarray,
    depth: Sequence[np.ndarray],
    transmittance: Sequence[np.ndarray],
    foggy: Sequence[np.ndarray],
) -> np.ndarray:
    """Sums by class and distance: float64 (C + 1, D, 5), the last class being what has no label; last axis as `SUMS`.

    labels : trainIds, uint8 (H, W)
    depth : true and other planar depth in metres, (H, W), above 0
    transmittance : of either, (H, W); foggy : images of either, uint8 (H, W, 3)

    >>> labels, near = np.zeros((1, 2), np.uint8), np.array([[10.0, 10.0]])
    >>> image = np.zeros((1, 2, 3), np.uint8)
    >>> sums(labels, (near, near + 1), (near / 20, near / 20), (image, image + 3))[0, 0].tolist()
    [2.0, 2.0, 0.2, 0.0, 6.0]
    """
    truth, other = (np.minimum(np.asarray(each, np.float64), FARTHEST) for each in depth)
    apart = np.abs(other - truth)
    errors = (
        np.ones_like(apart),
        apart,
        apart / truth,
        np.abs(np.asarray(transmittance[1], np.float64) - transmittance[0]),
        np.abs(foggy[1].astype(np.float64) - foggy[0]).mean(axis=2),
    )
    classes = np.where(labels == IGNORE, len(CLASSES), labels).astype(np.int64)
    place = classes * len(GROUPS) + np.searchsorted(EDGES[1:-1], depth[0], side="right")
    shape = len(CLASSES) + 1, len(GROUPS)
    found = [np.bincount(place.reshape(-1), each.reshape(-1), shape[0] * shape[1]).reshape(shape) for each in errors]
    return np.stack(found, axis=-1)
