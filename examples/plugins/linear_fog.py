"""A fog model: transmittance falls linearly with distance, to nothing at the visibility, 2.996 / beta.

A toy, to be seen in the numbers at once: real fog takes the same share of light from every metre (Koschmieder), which
gives exp(-beta l). This file's name is what `fog.model` names.
"""

from collections.abc import Sequence

import numpy as np

from foggy_synscapes.fog.geometry import Rays
from foggy_synscapes.fog.models import FogModel
from foggy_synscapes.fog.optics import count_zero_depth, meteorological_optical_range


def transmittance(depth: np.ndarray, rays: Rays, beta: float) -> np.ndarray:
    """Share of light that comes through, float64 (H, W), at a beta in 1/m; a beta of 0 is no fog.

    depth : float32 (H, W), planar metres; ValueError if any is negative or NaN
    """
    count_zero_depth(depth)
    if beta == 0:
        return np.ones(depth.shape)
    distance = depth * rays.factor()
    return np.maximum(0.0, 1.0 - distance / meteorological_optical_range(beta))


def images(
    image: np.ndarray, depth: np.ndarray, rays: Rays, airlight: Sequence[int], betas: Sequence[float]
) -> np.ndarray:
    """Foggy images, uint8 (B, H, W, 3): the clear one, and the airlight in its place where light does not come through.

    image : uint8 (H, W, 3); airlight : three levels
    """
    shares = [transmittance(depth, rays, beta)[..., None] for beta in betas]
    return np.stack([_level(t * image + (1 - t) * np.array(airlight)) for t in shares])


def transmittances(depth: np.ndarray, rays: Rays, betas: Sequence[float]) -> np.ndarray:
    """Transmittance in 8 bits, uint8 (B, H, W), for maps of it."""
    return np.stack([_level(255 * transmittance(depth, rays, beta)) for beta in betas])


def _level(values: np.ndarray) -> np.ndarray:
    return np.floor(values + 0.5).astype(np.uint8)


FOG_MODEL = FogModel(
    text="a toy: transmittance falls linearly to 0 at the visibility", images=images, transmittances=transmittances
)
