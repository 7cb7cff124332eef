"""Cheaper and rougher ways of rendering fog, to measure what they save and what they cost.

Each takes image uint8 (H, W, 3), planar depth float32 (H, W) in metres, camera, airlight (three levels) and betas in
1/m, and gives uint8 (B, H, W, 3). Most are plain NumPy over blocks of rows, so that their times compare.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from foggy_synscapes.camera import Camera
from foggy_synscapes.fog.geometry import rays, straight
from foggy_synscapes.fog.optics import foggy_images
from foggy_synscapes.stability.formats import to_bfloat16

BLOCK = 8  # rows: what is worked on at once stays in the processor's cache

Way = Callable[[np.ndarray, np.ndarray, Camera, Sequence[int], Sequence[float]], np.ndarray]
Cast = Callable[[np.ndarray], np.ndarray]
Transmittance = Callable[[np.ndarray, np.ndarray, Sequence[float]], Iterator[np.ndarray]]
"""From planar depth and metres along the ray per metre of depth to transmittance at each beta, for a block of rows."""


@dataclass(frozen=True)
class Variant:
    """A way of rendering; `timed` is false where the arithmetic is emulated and its time says nothing."""

    name: str
    about: str
    way: Way
    timed: bool = True


def variants() -> list[Variant]:
    """All variants, the reference first and this project's own way last."""
    return [
        Variant("float64", "plain formula, one exp per beta: the reference", _plain(np.float64)),
        Variant("shared powers", "float64, one exp; other betas by squares and products", partial(_blocks, _shared)),
        Variant("float32", "plain formula", _plain(np.float32)),
        Variant("float16", "plain formula", _plain(np.float16)),
        Variant("bfloat16", "rounded after each operation", _plain(np.float32, to_bfloat16), timed=False),
        Variant("half depth", "depth stored in float16", _half_depth),
        Variant("t in 8 bits", "from stored transmittance", _stored(255, np.uint8)),
        Variant("t in 16 bits", "from stored transmittance", _stored(65535, np.uint16)),
        Variant("planar depth", "depth taken for distance", _planar),
        Variant("exact geometry", "fx and fy, pixel centres", partial(_compiled, geometry="exact")),
        Variant("compiled", "float32 with float64 near a step, compiled: the default", _compiled),
    ]


def _as_it_is(values: np.ndarray) -> np.ndarray:
    return values


def _blocks(
    transmittance: Transmittance, image: np.ndarray, depth: np.ndarray, camera: Camera, airlight: Sequence[int],
    betas: Sequence[float], dtype: type = np.float64, cast: Cast = _as_it_is,
) -> np.ndarray:  # fmt: skip
    """Fog in blocks of rows, computed in `dtype` and rounded by `cast` after each operation."""
    height, width = depth.shape
    out, lines = np.empty((len(betas), *image.shape), np.uint8), rays(camera)
    lights = cast(np.array(airlight, dtype) / dtype(255))
    for top in range(0, height, BLOCK):
        rows = slice(top, min(top + BLOCK, height))
        factor = lines.crop(top, 0, rows.stop - top, width).factor()
        clear = cast(np.ascontiguousarray(image[rows].transpose(2, 0, 1)) / dtype(255))
        for t, foggy in zip(transmittance(depth[rows], factor, betas), out, strict=True):
            hidden = cast(1 - t)
            # Channel by channel, because NumPy is slow on axes of 3.
            for channel, light in enumerate(lights):
                radiance = cast(cast(t * clear[channel]) + cast(hidden * light))
                levels = np.floor(cast(cast(radiance * 255) + dtype(0.5)))
                foggy[rows, :, channel] = np.clip(levels, 0, 255).astype(np.uint8)
    return out


def _plain(dtype: type, cast: Cast = _as_it_is) -> Way:
    def transmittance(metres: np.ndarray, factor: np.ndarray, betas: Sequence[float]) -> Iterator[np.ndarray]:
        # The factor is the camera's and is made once in float64; what is stored and computed on is `dtype`.
        distance = cast(cast(metres.astype(dtype)) * cast(factor.astype(dtype)))
        return (cast(np.exp(cast(cast(np.array(-beta, dtype)) * distance))) for beta in betas)

    return partial(_blocks, transmittance, dtype=dtype, cast=cast)


def _shared(metres: np.ndarray, factor: np.ndarray, betas: Sequence[float]) -> Iterator[np.ndarray]:
    distance, base = metres * factor, min(betas)
    squares = [np.exp(-base * distance)]
    for beta in betas:
        power = round(beta / base)
        if abs(power * base - beta) > 1e-12 * beta:
            yield np.exp(-beta * distance)  # not a multiple of the smallest
            continue
        while 2 ** len(squares) <= power:
            squares.append(squares[-1] * squares[-1])
        factors = [square for bit, square in enumerate(squares) if power >> bit & 1]
        t = factors[0]
        for other in factors[1:]:
            t = t * other
        yield t


def _stored(steps: int, dtype: type) -> Way:
    def transmittance(metres: np.ndarray, factor: np.ndarray, betas: Sequence[float]) -> Iterator[np.ndarray]:
        distance = metres * factor
        return (np.floor(np.exp(-beta * distance) * steps + 0.5).astype(dtype) / steps for beta in betas)

    return partial(_blocks, transmittance)


def _compiled(
    image: np.ndarray, depth: np.ndarray, camera: Camera, airlight: Sequence[int], betas: Sequence[float],
    geometry: str = "paper",
) -> np.ndarray:  # fmt: skip
    return foggy_images(image, depth, rays(camera, geometry), airlight, betas)


def _half_depth(
    image: np.ndarray, depth: np.ndarray, camera: Camera, airlight: Sequence[int], betas: Sequence[float]
) -> np.ndarray:
    return _compiled(image, depth.astype(np.float16).astype(np.float32), camera, airlight, betas)


def _planar(
    image: np.ndarray, depth: np.ndarray, camera: Camera, airlight: Sequence[int], betas: Sequence[float]
) -> np.ndarray:
    return foggy_images(image, depth, straight(depth.shape), airlight, betas)
