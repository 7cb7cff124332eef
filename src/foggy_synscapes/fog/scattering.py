"""Light that fog scatters into a ray from the scene itself: what the law of uniform airlight takes for the surround's.

    F = E + t (R - E) + c (1 - t) G,   G = R - E, blurred
in linear light: R clear radiance, E that of the surround. A share c of the airlight is the blurred scene instead of E.
The blur stands for scattering forward by some degrees; t is that of the receiving pixel, so depth edges stay sharp.
"""

import math

import numpy as np

from foggy_synscapes.fog.geometry import Rays
from foggy_synscapes.fog.radiance import encoded

OPEN, GROUND = "open", "ground"
LARGEST_CELL, PER_BLUR = 16, 3
"""Pixels on each side that are averaged at most before the blur, and how many times as wide the blur is at least."""
TABLE = 1 << 16
REACH = 3.0
"""Standard deviations to which the blur looks."""


def blurred(radiance: np.ndarray, rays: Rays, degrees: float, beyond: str) -> tuple[np.ndarray, int]:
    """R - E, averaged over cells and blurred by a Gaussian: float32 (h, w, 3), and pixels on a cell's side.

    One cell on each side is beyond the frame.

    radiance : R - E, float32 (H, W, 3), linear; degrees : standard deviation of the blur
    beyond : outside of the frame: open: E everywhere; ground: below the axis the mean of the frame's lowest tenth

    Raises ValueError where the blur is wider than the image, or the rays are without directions.
    """
    height, width = radiance.shape[:2]
    focal = focal_length(rays)
    sigma = focal * math.tan(math.radians(degrees))
    if sigma > max(height, width):
        widest = math.degrees(math.atan(max(height, width) / focal))
        raise ValueError(f"blur: {degrees:g} degrees, wider than the image: expected up to {widest:.3g} degrees here")
    cell = max(1, min(LARGEST_CELL, int(sigma / PER_BLUR)))
    ground = np.zeros(3, np.float32)
    axis = height
    if beyond == GROUND:
        down, _ = rays.directions()
        ground = radiance[height - max(1, height // 10) :].mean(axis=(0, 1))
        axis = int(np.searchsorted(down, 0.0))
    small = _averaged(radiance, cell, axis, ground)
    rim = math.ceil(REACH * sigma / cell)
    wide = np.zeros((small.shape[0] + 2 * rim, small.shape[1] + 2 * rim, 3), np.float32)
    wide[rim + axis // cell :] = ground
    wide[rim : rim + small.shape[0], rim : rim + small.shape[1]] = small
    rows, columns = (_gaussian(size, rim, sigma / cell) for size in small.shape[:2])
    return np.einsum("ij,jkc,lk->ilc", rows, wide, columns, optimize=True).astype(np.float32), cell


def focal_length(rays: Rays) -> float:
    """Pixels per unit of the tangent of a ray's angle; 1 where the image is a single pixel."""
    down, right = rays.directions()
    longer = right if right.size > 1 else down
    return float((longer.size - 1) / (longer[-1] - longer[0])) if longer.size > 1 else 1.0


def level_table() -> np.ndarray:
    """Levels, uint8 (TABLE + 1,), of linear radiance in equal steps from 0 to 1."""
    return np.floor(encoded(np.arange(TABLE + 1) / TABLE) + 0.5).astype(np.uint8)


def _averaged(values: np.ndarray, cell: int, axis: int, ground: np.ndarray) -> np.ndarray:
    """Means over cells; the last ones reach beyond the frame, where there is `ground` below the axis and 0 above."""
    height, width = values.shape[:2]
    over = -height % cell, -width % cell
    if any(over):
        values = np.pad(values, ((0, over[0]), (0, over[1]), (0, 0)))
        values[axis:, width:] = ground
        values[height:] = ground
    rows, columns = values.shape[0] // cell, values.shape[1] // cell
    return values.reshape(rows, cell, columns, cell, 3).mean(axis=(1, 3), dtype=np.float32)


def _gaussian(size: int, rim: int, sigma: float) -> np.ndarray:
    """Weights (size + 2, size + 2 rim) by which a line with its rims is blurred, and one more on each side; sums 1.

    So pixels of the outermost cells lie between two blurred values as all others do.
    """
    offset = np.arange(size + 2 * rim)[None, :] - rim - np.arange(-1, size + 1)[:, None]
    weights = np.where(np.abs(offset) <= rim, np.exp(-0.5 * (offset / max(sigma, 1e-6)) ** 2), 0.0)
    return (weights / weights.sum(axis=1, keepdims=True)).astype(np.float32)
