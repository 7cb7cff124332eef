"""Models whose fog is even but for an effective distance: what composites even fog does the rest."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from foggy_synscapes.fog.geometry import Rays, straight
from foggy_synscapes.fog.models.model import FogModel
from foggy_synscapes.fog.models.settings import Settings
from foggy_synscapes.fog.optics import count_zero_depth, foggy_images, foggy_scan_lines, transmittance_images

Distance = Callable[[np.ndarray, Rays, Sequence[float]], np.ndarray]
"""From planar depth float32 (H, W), rays and betas: effective distance, float32 (H, W), metres."""


def with_distance(
    text: str, distance: Distance, settings: type[Settings], configure: Callable[[Any], FogModel]
) -> FogModel:
    """The model that takes t = exp(-beta d) with this effective distance d."""

    def checked(depth: np.ndarray, rays: Rays, betas: Sequence[float]) -> np.ndarray:
        count_zero_depth(depth)
        if depth.shape != rays.shape:
            raise ValueError(f"shapes differ: depth {depth.shape}, camera {rays.shape} (rows, columns)")
        return distance(depth, rays, betas)

    def images(
        image: np.ndarray, depth: np.ndarray, rays: Rays, airlight: Sequence[int], betas: Sequence[float]
    ) -> np.ndarray:
        return foggy_images(image, checked(depth, rays, betas), straight(depth.shape), airlight, betas)

    def scan_lines(
        image: np.ndarray, depth: np.ndarray, rays: Rays, airlight: Sequence[int], betas: Sequence[float]
    ) -> Callable[[slice, np.ndarray], None]:
        return foggy_scan_lines(image, checked(depth, rays, betas), straight(depth.shape), airlight, betas)

    def transmittances(depth: np.ndarray, rays: Rays, betas: Sequence[float]) -> np.ndarray:
        return transmittance_images(checked(depth, rays, betas), straight(depth.shape), betas)

    return FogModel(text, images, transmittances, scan_lines, settings, configure)
