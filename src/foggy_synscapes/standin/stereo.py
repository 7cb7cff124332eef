"""The disparity that a stereo camera would measure: noisy, with holes; and the simple completion of such maps.

Fog made from it is what "partially synthetic" means: real texture, imperfect depth.
"""

import numpy as np

from foggy_synscapes.standin.canvas import FARTHEST
from foggy_synscapes.standin.render import EGO, Scene
from foggy_synscapes.standin.style import upsample

BASELINE = 0.209313
"""Metres between the two cameras of Cityscapes."""

REFERENCE_COLUMNS = 2048
"""Columns of a Cityscapes image: errors in pixels are stated at this size and scaled."""

MATCHING_ERROR = 0.35
"""Standard deviation of the disparity in pixels at the reference size."""


def measure(scene: Scene, rng: np.random.Generator) -> np.ndarray:
    """Disparity as Cityscapes stores it, uint16 (H, W): 256 d + 1, and 0 where no match was found.

    Missing are what the other camera cannot see (beyond its edge, or behind something nearer), the own car,
    most of the sky and some patches; a few patches of sky match by mistake at 80 to 400 m.
    """
    rows, columns = scene.depth.shape
    exact = scene.rig.fx * BASELINE / scene.depth.astype(np.float64)
    found = exact + MATCHING_ERROR * (columns / REFERENCE_COLUMNS) * rng.standard_normal(exact.shape)
    landing = np.arange(columns) - exact
    nearer = np.minimum.accumulate(landing[:, ::-1], axis=1)[:, ::-1]
    patches = upsample(rng.standard_normal((rows // 6 + 2, columns // 6 + 2)), (rows, columns))
    sky = scene.depth > FARTHEST
    wrong = sky & (patches < -0.75)
    found = np.where(wrong, scene.rig.fx * BASELINE / (80 + 180 * np.clip(patches + 2.5, 0, 1.75)), found)
    hidden = (landing < 0) | (landing > nearer + 0.5)
    missing = hidden | (patches > 1.0) | (scene.label_ids == EGO) | (sky & ~wrong)
    return np.where(missing, 0, np.clip(np.floor(found * 256 + 0.5) + 1, 1, 65535)).astype(np.uint16)


def complete(stored: np.ndarray) -> np.ndarray:
    """Disparity in pixels with holes filled, float64 (H, W), from the stored form.

    A hole takes the farther of its neighbours left and right, as what is hidden lies behind; a row without
    any value takes the next row's below, or else above.

    Raises ValueError if no pixel has a value.

    >>> complete(np.array([[0, 0], [513, 0]], dtype=np.uint16)).tolist()
    [[2.0, 2.0], [2.0, 2.0]]
    """
    value = np.where(stored > 0, (stored.astype(np.float64) - 1) / 256, np.inf)
    filled = np.minimum(_carried(value), _carried(value[:, ::-1])[:, ::-1])
    good = np.flatnonzero(np.isfinite(filled).all(axis=1))
    if not good.size:
        raise ValueError("stored: no pixel of the disparity has a value")
    below = np.searchsorted(good, np.arange(len(filled)))
    return filled[good[np.minimum(below, len(good) - 1)]]


def _carried(value: np.ndarray) -> np.ndarray:
    # Each known value until the next one to its right; inf before the first.
    last = np.maximum.accumulate(np.where(np.isfinite(value), np.arange(value.shape[1]), 0), axis=1)
    return np.take_along_axis(value, last, axis=1)


def to_depth(disparity: np.ndarray, fx: float) -> np.ndarray:
    """Planar depth in metres, at most that of the sky dome, from disparity and focal length in pixels."""
    with np.errstate(divide="ignore"):
        return np.minimum(fx * BASELINE / np.maximum(disparity, 0), 8000.0)
