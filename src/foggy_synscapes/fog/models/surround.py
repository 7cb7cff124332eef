"""Homogeneous fog whose airlight is partly the scene's own light, scattered: experimental, see docs/fog_models.md.

The law of uniform airlight takes all that is scattered into a ray for as bright as the surround; in a street half of it
comes from the dark street. Composited in linear light, unlike the published code, which mixes levels.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from foggy_synscapes.fog import scattering
from foggy_synscapes.fog.geometry import Rays
from foggy_synscapes.fog.models.model import FogModel
from foggy_synscapes.fog.models.settings import Settings, value
from foggy_synscapes.fog.optics import check_frame, count_zero_depth, transmittance_images
from foggy_synscapes.fog.radiance import linear

FITTED = {"open": (0.85, 6.0), "ground": (0.9, 3.0)}
"""Share and blur by surround, as `foggy atlas` fits them to path tracing."""


@dataclass(frozen=True)
class Surround(Settings):
    """Values of fog with scattered light."""

    share: float | None = value(
        "of the airlight that is the blurred scene; where it is not stated, as fitted to path tracing", None, ge=0, le=1
    )
    blur: float | None = value(
        "standard deviation of the Gaussian blur; where it is not stated, as fitted to path tracing",
        None,
        "degrees",
        gt=0,
        lt=60,
    )
    surround: str = value(
        "outside of the frame: open: the airlight from all sides; ground: below the camera's axis the frame's own road",
        "open",
        choices=("open", "ground"),
    )


@cache
def _levels() -> np.ndarray:
    return scattering.level_table()


def _model(values: Surround) -> FogModel:
    fitted = FITTED[values.surround]
    share = fitted[0] if values.share is None else values.share
    blur = fitted[1] if values.blur is None else values.blur

    def images(
        image: np.ndarray, depth: np.ndarray, rays: Rays, airlight: Sequence[int], betas: Sequence[float]
    ) -> np.ndarray:
        from foggy_synscapes.fog import scattering_kernel  # Numba takes half a second

        count_zero_depth(depth)
        light = check_frame(image, depth, rays, airlight, betas)
        radiance = linear(np.arange(256, dtype=np.uint8)).astype(np.float32)
        beyond = linear(light).astype(np.float32)
        glow, cell = scattering.blurred(radiance[image] - beyond, rays, blur, values.surround)
        out = np.empty((len(betas), *image.shape), np.uint8)
        frame = np.ascontiguousarray(image), np.ascontiguousarray(depth), rays.rows, rays.columns, float(rays.scale)
        scattering_kernel.lit(
            *frame, np.array(betas, float), beyond, radiance, glow, cell, np.float32(share), _levels(), out
        )
        return out

    return FogModel(
        "homogeneous fog, its airlight mixed with the blurred scene (values: share, blur, surround); in linear light; "
        "experimental",
        images,
        transmittance_images,
        settings=Surround,
        configure=_model,
    )


FOG_MODEL = _model(Surround())
