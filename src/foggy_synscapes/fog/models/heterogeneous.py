"""Uneven fog: extinction beta (1 + contrast noise), integrated along each ray, and uniform airlight.

The noise is periodic value noise (`uneven.noise`) in metres around the camera, moved for each frame by a digest of its
depth, so that frames differ and the same frame is the same at every beta.
"""

import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from foggy_synscapes.fog.geometry import Rays
from foggy_synscapes.fog.models.effective import with_distance
from foggy_synscapes.fog.models.model import FogModel
from foggy_synscapes.fog.models.settings import Settings, value
from foggy_synscapes.fog.uneven import GRID, OCTAVES, noise

REACH = 6.0
"""Optical depths at the lowest beta behind which no noise is looked at: t is 0.25 % there."""


FARTHEST = 1e6
"""Correlation lengths behind which no noise is looked at: positions there would lose their fractions."""


@dataclass(frozen=True)
class Heterogeneous(Settings):
    """Values of uneven fog."""

    seed: int = value("of the noise", 0, ge=0, le=2**31 - 1)
    correlation: float = value("size of the largest patches", 20.0, "m", ge=0.1, le=1e4)
    contrast: float = value("largest deviation from beta, as a share of it", 0.8, ge=0, le=1)
    steps: int = value("of the integral along a ray, midpoint rule", 10, ge=1, le=4096)


def _model(values: Heterogeneous) -> FogModel:
    def distance(depth: np.ndarray, rays: Rays, betas: Sequence[float]) -> np.ndarray:
        from foggy_synscapes.fog import uneven_kernel  # Numba takes half a second

        down, right = rays.directions()
        depth = np.ascontiguousarray(depth)
        moved = np.random.default_rng((values.seed, zlib.crc32(depth.data))).uniform(0, GRID, 3)
        lowest = min((beta for beta in betas if beta > 0), default=1.0)
        out = np.empty(depth.shape, np.float32)
        uneven_kernel.uneven(
            depth,
            rays.rows,
            rays.columns,
            rays.scale,
            right,
            down,
            noise(values.seed),
            values.correlation / OCTAVES[0],
            moved,
            values.contrast,
            min(REACH / lowest, FARTHEST * values.correlation),
            values.steps,
            out,
        )
        return out

    return with_distance(
        "uneven fog: seeded noise, integrated along the ray (values: seed, correlation, contrast, steps), uniform "
        "airlight",
        distance,
        Heterogeneous,
        _model,
    )


FOG_MODEL = _model(Heterogeneous())
