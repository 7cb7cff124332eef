"""Fog on one frame, from image, depth and camera: what the parts of this package are for."""

from collections.abc import Sequence

import numpy as np

from foggy_synscapes.camera import Camera
from foggy_synscapes.fog.airlight import estimate
from foggy_synscapes.fog.geometry import rays
from foggy_synscapes.fog.models.model import Images
from foggy_synscapes.fog.optics import foggy_images


def foggy_frame(
    image: np.ndarray,
    depth: np.ndarray,
    camera: Camera,
    betas: Sequence[float],
    geometry: str = "paper",
    images: Images = foggy_images,
) -> list[np.ndarray]:
    """Foggy images, uint8 (H, W, 3), one per beta in 1/m, with the airlight of the image itself.

    image : uint8 (H, W, 3); depth : float32 (H, W), planar metres; raises ValueError as `optics.foggy_images` does
    images : of the fog model
    """
    return list(images(image, depth, rays(camera, geometry), estimate(image).levels, betas))
