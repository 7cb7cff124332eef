"""Cheaper and rougher ways of rendering fog, to measure what they save and what they cost.

Each takes image uint8 (H, W, 3), planar depth float32 (H, W) in metres, camera, airlight (three levels) and betas in
1/m, and gives uint8 (B, H, W, 3). All but the last are plain NumPy over blocks of rows, so that their times compare.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from foggy_synscapes.camera import Camera
from foggy_synscapes.fog.geometry import Rays, rays, straight
from foggy_synscapes.fog.optics import foggy_images
from foggy_synscapes.stability.formats import to_bfloat16

BLOCK = 8  # rows: what is worked on at once stays in the processor's cache

Light = Sequence[int]
Way = Callable[[np.ndarray, np.ndarray, Camera, Light, Sequence[float]], np.ndarray]


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
        Variant("shared powers", "float64, one exp; other betas by squares and products", _shared),
        Variant("float32", "plain formula", _plain(np.float32)),
        Variant("float16", "plain formula", _plain(np.float16)),
        Variant("bfloat16", "rounded after each operation", _emulated, timed=False),
        Variant("half depth", "depth stored in float16", _half_depth),
        Variant("t in 8 bits", "from stored transmittance", _stored(255, np.uint8)),
        Variant("t in 16 bits", "from stored transmittance", _stored(65535, np.uint16)),
        Variant("planar depth", "depth taken for distance", _planar),
        Variant("exact geometry", "fx and fy, pixel centres", _exact_geometry),
        Variant("compiled", "float32 with float64 near a step, compiled: the default", _compiled),
    ]


def quantize(radiance: np.ndarray) -> np.ndarray:
    """Radiance in [0, 1] as levels: uint8, floor(255 F + 0.5)."""
    return np.clip(np.floor(radiance * 255 + radiance.dtype.type(0.5)), 0, 255).astype(np.uint8)


def _blocks(image: np.ndarray, depth: np.ndarray, lines: Rays) -> Iterator[tuple[slice, np.ndarray, np.ndarray, Rays]]:
    height, width = depth.shape
    for top in range(0, height, BLOCK):
        rows = slice(top, min(top + BLOCK, height))
        yield rows, image[rows], depth[rows], lines.crop(top, 0, rows.stop - top, width)


def _mix(t: np.ndarray, clear: np.ndarray, airlight: np.ndarray, out: np.ndarray) -> None:
    """Composite one block into uint8 (rows, W, 3); channel by channel, because NumPy is slow on axes of 3."""
    hidden = 1 - t
    for channel, light in enumerate(airlight):
        out[..., channel] = quantize(t * clear[channel] + hidden * light)


def _radiance(pixels: np.ndarray, dtype: type = np.float64) -> np.ndarray:
    return np.ascontiguousarray(pixels.transpose(2, 0, 1)) / dtype(255)


def _plain(dtype: type) -> Way:
    def way(
        image: np.ndarray, depth: np.ndarray, camera: Camera, airlight: Light, betas: Sequence[float]
    ) -> np.ndarray:
        out = np.empty((len(betas), *image.shape), np.uint8)
        light = np.array(airlight, dtype) / dtype(255)
        for rows, pixels, metres, lines in _blocks(image, depth, rays(camera)):
            # The factor is the camera's and is made once in float64; what is stored and computed on is `dtype`.
            distance: np.ndarray = metres.astype(dtype) * lines.factor().astype(dtype)
            clear = _radiance(pixels, dtype)
            for beta, foggy in zip(betas, out, strict=True):
                _mix(np.exp(dtype(-beta) * distance), clear, light, foggy[rows])
        return out

    return way


def _shared(
    image: np.ndarray, depth: np.ndarray, camera: Camera, airlight: Light, betas: Sequence[float]
) -> np.ndarray:
    base = min(betas)
    powers = [round(beta / base) for beta in betas]
    out = np.empty((len(betas), *image.shape), np.uint8)
    light = np.array(airlight) / 255
    for rows, pixels, metres, lines in _blocks(image, depth, rays(camera)):
        distance, clear = metres * lines.factor(), _radiance(pixels)
        squares = [np.exp(-base * distance)]
        for beta, power, foggy in zip(betas, powers, out, strict=True):
            if abs(power * base - beta) > 1e-12 * beta:
                _mix(np.exp(-beta * distance), clear, light, foggy[rows])  # not a multiple of the smallest
                continue
            while 2 ** len(squares) <= power:
                squares.append(squares[-1] * squares[-1])
            factors = [square for bit, square in enumerate(squares) if power >> bit & 1]
            t = factors[0]
            for factor in factors[1:]:
                t = t * factor
            _mix(t, clear, light, foggy[rows])
    return out


def _emulated(
    image: np.ndarray, depth: np.ndarray, camera: Camera, airlight: Light, betas: Sequence[float]
) -> np.ndarray:
    def cast(values: np.ndarray | float) -> np.ndarray:
        return to_bfloat16(np.asarray(values, np.float32))

    out = np.empty((len(betas), *image.shape), np.uint8)
    light = cast(np.array(airlight) / 255)
    for rows, pixels, metres, lines in _blocks(image, depth, rays(camera)):
        distance, clear = cast(cast(metres) * cast(lines.factor())), cast(pixels / np.float32(255))
        for beta, foggy in zip(betas, out, strict=True):
            t = cast(np.exp(-cast(cast(beta) * distance)))[..., None]
            radiance = cast(cast(t * clear) + cast(cast(1 - t) * light))
            foggy[rows] = np.clip(np.floor(cast(cast(radiance * 255) + np.float32(0.5))), 0, 255).astype(np.uint8)
    return out


def _half_depth(
    image: np.ndarray, depth: np.ndarray, camera: Camera, airlight: Light, betas: Sequence[float]
) -> np.ndarray:
    return _compiled(image, depth.astype(np.float16).astype(np.float32), camera, airlight, betas)


def _stored(steps: int, dtype: type) -> Way:
    def way(
        image: np.ndarray, depth: np.ndarray, camera: Camera, airlight: Light, betas: Sequence[float]
    ) -> np.ndarray:
        out = np.empty((len(betas), *image.shape), np.uint8)
        light = np.array(airlight) / 255
        for rows, pixels, metres, lines in _blocks(image, depth, rays(camera)):
            distance, clear = metres * lines.factor(), _radiance(pixels)
            for beta, foggy in zip(betas, out, strict=True):
                stored = np.floor(np.exp(-beta * distance) * steps + 0.5).astype(dtype)
                _mix(stored / steps, clear, light, foggy[rows])
        return out

    return way


def _planar(
    image: np.ndarray, depth: np.ndarray, camera: Camera, airlight: Light, betas: Sequence[float]
) -> np.ndarray:
    return foggy_images(image, depth, straight(depth.shape), airlight, betas)


def _exact_geometry(
    image: np.ndarray, depth: np.ndarray, camera: Camera, airlight: Light, betas: Sequence[float]
) -> np.ndarray:
    return foggy_images(image, depth, rays(camera, "exact"), airlight, betas)


def _compiled(
    image: np.ndarray, depth: np.ndarray, camera: Camera, airlight: Light, betas: Sequence[float]
) -> np.ndarray:
    return foggy_images(image, depth, rays(camera), airlight, betas)
