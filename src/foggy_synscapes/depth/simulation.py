"""What a stereo camera would measure of a scene whose depth is known: to learn what the quality of depth costs.

The model of its errors: no match where the other view sees nothing (behind something nearer, beyond its edge) nor where
the disparity is too small to be found; disparity elsewhere with noise, rounded to steps. The right view is the left
one, moved by the exact disparity, with noise of its own. Errors are stated at the width of Cityscapes and scaled.
"""

from dataclasses import dataclass

import numpy as np

from foggy_synscapes.camera import Camera
from foggy_synscapes.depth.completion import Stereo, complete
from foggy_synscapes.depth.disparity import UNITS

REFERENCE_COLUMNS = 2048
"""Columns of the image at which errors in pixels are stated."""
HALF = 0.5
"""Of a pixel, at the size of the image: what lands that much farther left than something beside it is hidden."""


@dataclass(frozen=True)
class Errors:
    """What a stereo camera does wrong; pixels at `REFERENCE_COLUMNS`.

    baseline : metres between both views
    noise : standard deviation of the disparity; step : to which it is rounded; least : that is found
    levels : standard deviation of the right view's own noise, in levels of 8 bits
    """

    baseline: float
    noise: float
    step: float
    least: float
    levels: float


def measure(
    image: np.ndarray, depth: np.ndarray, camera: Camera, errors: Errors, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Right view, uint8 (H, W, 3), and disparity as Cityscapes stores it, uint16 (H, W), 0 where there is none.

    image : uint8 (H, W, 3); depth : (H, W), planar metres above 0, infinity is allowed; camera : of the left view

    >>> image, depth = np.full((1, 5, 3), 90, np.uint8), np.array([[10.0, 10.0, 10.0, 10.0, 2.5]])
    >>> camera = Camera(fx=10.0, fy=10.0, u0=2.0, v0=0.5, resx=5, resy=1)
    >>> exact = Errors(baseline=1.0, noise=0.0, step=1 / 256, least=0.0, levels=0.0)
    >>> measure(image, depth, camera, exact, np.random.default_rng(0))[1].tolist()  # outside, 1 px, hidden twice, 4 px
    [[0, 257, 0, 0, 1025]]
    """
    columns = depth.shape[1]
    finer = columns / REFERENCE_COLUMNS
    exact = camera.fx * errors.baseline / np.asarray(depth, np.float64)
    landing = np.arange(columns) - exact
    nearest = np.minimum.accumulate(landing[:, ::-1], axis=1)[:, ::-1]
    hidden = (landing < 0) | (landing > nearest + HALF)
    found = exact + errors.noise * finer * rng.standard_normal(exact.shape)
    step = errors.step * finer
    found = np.floor(found / step + 0.5) * step
    missing = hidden | (found < errors.least * finer)
    stored = np.clip(np.floor(found * UNITS + 0.5) + 1, 1, 65535)
    return _right(image, landing, errors.levels, rng), np.where(missing, 0, stored).astype(np.uint16)


def _right(image: np.ndarray, landing: np.ndarray, levels: float, rng: np.random.Generator) -> np.ndarray:
    """The image moved to where its pixels land; what lies beside a gap on the left, being farther, fills it."""
    rows, columns = landing.shape
    source = np.full((rows, columns), -1)
    order = np.argsort(-landing + np.arange(columns), axis=None, kind="stable")  # disparity: from far to near
    row, column = np.unravel_index(order, landing.shape)
    to = np.floor(landing[row, column] + 0.5).astype(np.int64)
    seen = to >= 0
    source[row[seen], to[seen]] = column[seen]  # of several the last, nearest one stays
    known = np.maximum.accumulate(np.where(source >= 0, np.arange(columns), -1), axis=1)
    first = np.argmax(source >= 0, axis=1)[:, None]
    source = np.take_along_axis(source, np.where(known >= 0, known, first), axis=1)
    moved = np.take_along_axis(image, np.maximum(source, 0)[..., None], axis=1)
    return np.clip(np.floor(moved + levels * rng.standard_normal(moved.shape) + 0.5), 0, 255).astype(np.uint8)


def completed(
    image: np.ndarray, depth: np.ndarray, camera: Camera, errors: Errors, seeds: tuple[int, int], superpixels: int
) -> np.ndarray:
    """Depth as it is completed from what a stereo camera would measure: float64 (H, W), planar metres.

    seeds : of the camera's noise, and of the frame; others as in `measure`

    Raises ValueError as `completion.complete` does.
    """
    right, stored = measure(image, depth, camera, errors, np.random.default_rng(seeds))
    return complete(image, right, stored, Stereo(camera, errors.baseline), wanted=superpixels).depth
