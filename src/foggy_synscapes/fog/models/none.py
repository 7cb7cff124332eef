"""No fog: the image as it is, copied. Enough where fog would change no level, see `is_enough`."""

from collections.abc import Sequence

import numpy as np

from foggy_synscapes.fog.geometry import Rays
from foggy_synscapes.fog.models.model import FogModel
from foggy_synscapes.fog.optics import count_zero_depth

HALF = 0.5
"""Levels: a change below it leaves every level as it is."""


def images(
    image: np.ndarray, depth: np.ndarray, rays: Rays, airlight: Sequence[int], betas: Sequence[float]
) -> np.ndarray:
    """The image itself, once per beta: uint8 (B, H, W, 3); depth, rays and airlight are not looked at."""
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3 or image.size == 0:
        raise ValueError(f"image: {image.dtype} {image.shape}, expected uint8 (H, W, 3)")
    return np.repeat(image[None], len(betas), axis=0)


def transmittances(depth: np.ndarray, rays: Rays, betas: Sequence[float]) -> np.ndarray:
    """All light comes through: 255 everywhere, uint8 (B, H, W)."""
    count_zero_depth(depth)
    return np.full((len(betas), *depth.shape), 255, np.uint8)


def is_enough(image: np.ndarray, depth: np.ndarray, rays: Rays, airlight: Sequence[int], beta: float) -> bool:
    """Whether homogeneous fog would change no level: (1 - t) |airlight - image| below half a level at every pixel.

    At infinite depth t is 0, so an infinite sky has to have the airlight's own levels.

    >>> from foggy_synscapes.fog.geometry import straight
    >>> image = np.full((1, 1, 3), 100, np.uint8)
    >>> [is_enough(image, np.full((1, 1), 10, np.float32), straight((1, 1)), (200,) * 3, b) for b in (4e-4, 6e-4)]
    [True, False]
    """
    if beta == 0:
        return True
    # Where the most distant pixel times the largest difference stays below, no other has to be looked at.
    lost = -np.expm1(-beta * (depth * rays.factor()))
    far = np.abs(image.astype(np.int16) - np.array(airlight, np.int16)).max(axis=2)
    return bool((lost * far < HALF).all())


FOG_MODEL = FogModel(text="no fog: the clear image, copied", images=images, transmittances=transmittances)
