"""Layered fog: extinction falls with height above the road, beta exp(-h / H), and airlight is uniform.

Source: the exponential height profile is the common one in atmospheric optics (see `uneven.layered` for its integral).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from foggy_synscapes.fog.geometry import Rays
from foggy_synscapes.fog.models.effective import with_distance
from foggy_synscapes.fog.models.model import FogModel
from foggy_synscapes.fog.models.settings import Settings, value


@dataclass(frozen=True)
class Layered(Settings):
    """Values of layered fog; the camera's are those of the published Synscapes samples."""

    scale_height: float = value(
        "height by which the fog thins to a share of 1/e; radiation fog is some metres to tens of metres deep",
        20.0,
        "m",
        ge=0.5,
        le=1e5,
    )
    camera_height: float = value("of the camera above the road", 1.22, "m", ge=0, le=10)
    pitch: float = value("of the camera, positive downwards", 0.038, "rad", gt=-1.57, lt=1.57)


def _model(values: Layered) -> FogModel:
    def distance(depth: np.ndarray, rays: Rays, _betas: Sequence[float]) -> np.ndarray:
        from foggy_synscapes.fog import uneven_kernel  # Numba takes half a second

        down, _ = rays.directions()
        rises = -down * math.cos(values.pitch) - math.sin(values.pitch)
        out = np.empty(depth.shape, np.float32)
        ratio = values.camera_height / values.scale_height
        uneven_kernel.layered(
            np.ascontiguousarray(depth),
            rays.rows,
            rays.columns,
            rays.scale,
            rises / values.scale_height,
            -ratio,
            math.exp(-ratio),
            out,
        )
        return out

    return with_distance(
        "fog that thins with height above the road (values: scale_height, camera_height, pitch), uniform airlight",
        distance,
        Layered,
        _model,
    )


FOG_MODEL = _model(Layered())
