"""The right view of the stand-in's stereo camera: the left one moved by its exact disparity."""

import numpy as np

from foggy_synscapes.standin.render import Scene
from foggy_synscapes.standin.stereo import BASELINE

NOISE = 1.5
"""Standard deviation of the right camera's own noise, in levels of 8 bits: within the 12 that completion allows."""


def draw(scene: Scene, rng: np.random.Generator) -> np.ndarray:
    """The scene as the right camera sees it, uint8 (H, W, 3).

    Near pixels hide far ones; where the left view shows nothing, what is beside on the left, being farther, goes on.
    """
    rows, columns = scene.depth.shape
    landing = np.floor(np.arange(columns) - scene.rig.fx * BASELINE / scene.depth.astype(np.float64) + 0.5)
    source = np.full((rows, columns), -1)
    row, column = np.unravel_index(np.argsort(-scene.depth, axis=None, kind="stable"), scene.depth.shape)
    to = landing[row, column].astype(np.int64)
    seen = to >= 0
    source[row[seen], to[seen]] = column[seen]  # in this order: of several the last, nearest one stays
    known = np.maximum.accumulate(np.where(source >= 0, np.arange(columns), -1), axis=1)
    first = np.argmax(source >= 0, axis=1)[:, None]
    source = np.take_along_axis(source, np.where(known >= 0, known, first), axis=1)
    moved = np.take_along_axis(scene.rgb, np.maximum(source, 0)[..., None], axis=1)
    noisy = moved + NOISE * rng.standard_normal(moved.shape)
    return np.clip(np.floor(noisy + 0.5), 0, 255).astype(np.uint8)
