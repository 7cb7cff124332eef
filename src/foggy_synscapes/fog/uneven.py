"""Fog that is not alike everywhere: how far light would travel through even fog to lose as much.

Extinction is beta times a relative density rho along the ray, so t = exp(-beta d) with the effective distance
d = integral of rho from 0 to l. It does not depend on beta; and as distances, all that composites even fog takes it.
"""

import math
from functools import lru_cache

import numpy as np

from foggy_synscapes.fog.geometry import Rays

FARTHEST = 1e30
"""Metres, in place of infinity, which would meet zeros."""
GRID = 64
"""Cells on each side of the periodic noise."""
OCTAVES = (8, 4, 2)
"""Cells, size of its features; each octave half as strong as the one before."""


def layered(depth: np.ndarray, rays: Rays, scale_height: float, camera_height: float, pitch: float) -> np.ndarray:
    """Effective distance where density falls with height above the road, rho = exp(-h / H): float64 (H, W), metres.

    d = exp(-h0 / H) l phi(s l / H) with phi(x) = (1 - exp(-x)) / x, h0 the camera's height, s the sine by which the ray
    rises; below the road density is as on it, as far as single points dip. This is the formula; the loop that models
    run is `uneven_kernel.layered`.

    Parameters
    ----------
    depth : (H, W), planar metres, at least 0; rays : with directions
    scale_height : metres, above 0; camera_height : metres above the road; pitch : radians, positive downwards

    Raises ValueError where the rays are without directions.

    >>> from foggy_synscapes.camera import Camera
    >>> from foggy_synscapes.fog.geometry import rays
    >>> up = rays(Camera(fx=1e-3, fy=1e-3, u0=1.0, v0=2.0, resx=1, resy=1))     # looks up: 1000 m per metre of depth
    >>> d = layered(np.array([[1e6]]), up, 10.0, 0.0, 0.0)    # through all of the fog
    >>> bool(abs(d[0, 0] - 10) < 1e-4)
    True
    """
    down, _ = rays.directions()
    metres = np.minimum(np.asarray(depth, dtype=np.float64), FARTHEST)
    rise = (-down * math.cos(pitch) - math.sin(pitch))[:, None] * metres
    x = np.maximum(rise, -camera_height) / scale_height
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.where(x == 0, 1.0, -np.expm1(-x) / x)
    return math.exp(-camera_height / scale_height) * metres * rays.factor() * share


@lru_cache(maxsize=2)
def noise(seed: int) -> np.ndarray:
    """Periodic value noise of several octaves: float32 (GRID, GRID, GRID), mean 0, largest magnitude 1.

    seed : at least 0, decides it
    """
    rng = np.random.default_rng((seed, GRID))
    total = np.zeros((GRID,) * 3, np.float32)
    for strength, size in enumerate(OCTAVES):
        coarse = rng.uniform(-1, 1, (GRID // size,) * 3).astype(np.float32)
        for axis in range(3):
            coarse = _finer(coarse, axis, size)
        total += coarse * np.float32(0.5**strength)
    total -= total.mean(dtype=np.float64).astype(np.float32)
    return total / np.abs(total).max()


def _finer(values: np.ndarray, axis: int, size: int) -> np.ndarray:
    """A periodic array, interpolated so that a step along an axis becomes `size` ones, smooth at its ends."""
    share = np.arange(size) / size
    share = (share * share * (3 - 2 * share)).astype(np.float32)
    moved = np.moveaxis(values, axis, -1)
    following = np.roll(moved, -1, axis=-1)
    between = moved[..., None] * (1 - share) + following[..., None] * share
    return np.moveaxis(between.reshape(*moved.shape[:-1], -1), -1, axis)
