"""From a measured disparity to depth, and which of it can be relied on. Source: IJCV 2018, section 3.1."""

import numpy as np

UNITS = 256
"""A stored disparity v means (v - 1) / 256 pixels, and 0 that there is none (Cityscapes)."""

CONSISTENT = 12 / 255
"""Largest distance in RGB, each from 0 to 1, between a pixel and its match in the right view."""


def pixels(stored: np.ndarray) -> np.ndarray:
    """Disparity in pixels, float64 (H, W), of stored values uint16 (H, W); -1/256 where there is none.

    >>> pixels(np.array([[0, 1, 513]], np.uint16)).tolist()
    [[-0.00390625, 0.0, 2.0]]
    """
    return (stored.astype(np.float64) - 1) / UNITS


def depth(stored: np.ndarray, baseline: float, fx: float) -> np.ndarray:
    """Planar depth in metres, float64 (H, W): infinity at a disparity of 0, and where there is none.

    Parameters
    ----------
    stored : disparity, uint16 (H, W), see `pixels`
    baseline : metres between the cameras, above 0
    fx : focal length in pixels, above 0

    >>> depth(np.array([[0, 1, 513]], np.uint16), 0.5, 400.0).tolist()
    [[inf, inf, 100.0]]
    """
    found = pixels(stored)
    return np.divide(baseline * fx, found, out=np.full(stored.shape, np.inf), where=found > 0)


def inconsistent(left: np.ndarray, right: np.ndarray, stored: np.ndarray) -> np.ndarray:
    """Pixels whose match in the right view is outside of it or looks otherwise: bool (H, W).

    The match of column x is x - d, rounded to the nearest column, halves away from zero.

    left, right : uint8 (H, W, 3); stored : disparity, uint16 (H, W)

    >>> left, right = np.full((1, 3, 3), 90, np.uint8), np.full((1, 3, 3), 90, np.uint8)
    >>> right[0, 1] = 200
    >>> inconsistent(left, right, np.array([[1, 1, 257]], np.uint16)).tolist()     # d = 0, 0 and 1
    [[False, True, True]]
    """
    from foggy_synscapes.depth.kernels.pixels import inconsistent as mark

    out = np.empty(stored.shape, np.bool_)
    views = np.ascontiguousarray(left), np.ascontiguousarray(right)
    mark(*views, pixels(stored), np.arange(256) / 255, CONSISTENT * CONSISTENT, out)
    return out
