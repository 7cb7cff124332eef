"""Light through homogeneous fog: transmittance, visibility, and fog composited on 8-bit images.

F(x) = t(x) R(x) + (1 - t(x)) L with t(x) = exp(-beta l(x)): R clear radiance, L atmospheric light, l distance
along the ray. Source: Koschmieder 1924; paper, equations (1) and (2).
"""

import math
from collections.abc import Sequence

import numpy as np

from foggy_synscapes.fog.geometry import Rays

CONTRAST = 2.996
"""beta times meteorological optical range: -ln 0.05, rounded as in the paper, section III."""

LIGHTEST = CONTRAST / 1000
"""1/m; below it visibility exceeds 1 km and the air is not foggy by definition (paper, section III)."""


def meteorological_optical_range(beta: float) -> float:
    """Visibility in metres at an attenuation coefficient in 1/m, above 0.

    >>> round(meteorological_optical_range(0.005))
    599
    """
    return CONTRAST / _attenuation(beta, "beta")


def attenuation(visibility: float) -> float:
    """Attenuation coefficient beta in 1/m at a meteorological optical range in metres, above 0.

    >>> attenuation(1000)
    0.002996
    """
    return CONTRAST / _attenuation(visibility, "visibility")


def transmittance(distance: np.ndarray, beta: float) -> np.ndarray:
    """Share of light that comes through: float64, from 0 to 1.

    Parameters
    ----------
    distance : metres along the ray, any shape, at least 0; infinity is allowed
    beta : attenuation coefficient, 1/m, at least 0; 0 lets all light through, also from infinity

    Raises ValueError if a distance or beta is negative or NaN, or beta is infinite.

    >>> transmittance(np.array([0.0, 100.0, np.inf]), math.log(2) / 100)
    array([1. , 0.5, 0. ])
    """
    distance = np.asarray(distance, dtype=np.float64)
    if not (distance >= 0).all():
        raise ValueError("distance: has values that are negative or not a number, expected metres")
    if not 0 <= beta < math.inf:
        raise ValueError(f"beta: {beta}, expected a finite number of 1/m that is not negative")
    if beta == 0:
        return np.ones_like(distance)
    return np.exp(-beta * distance)


def foggy_images(
    image: np.ndarray,
    depth: np.ndarray,
    rays: Rays,
    airlight: Sequence[int],
    betas: Sequence[float],
) -> np.ndarray:
    """Fog on one image at several densities: uint8 (B, H, W, 3), each value floor(255 F + 0.5).

    Arithmetic is float64, or of an accuracy that provably gives the same level (see `fog.kernel`).

    Parameters
    ----------
    image : uint8 (H, W, 3)
    depth : float32 (H, W), planar metres, at least 0; infinity gives the airlight
    rays : of the image's camera, see `fog.geometry`
    airlight : three levels, 0 to 255
    betas : 1/m, at least 0; 0 gives the image itself

    Raises ValueError if shapes differ, a depth or beta is negative or NaN, or beta is infinite.

    >>> from foggy_synscapes.fog.geometry import straight
    >>> image = np.full((1, 2, 3), 100, np.uint8)
    >>> depth = np.array([[100.0, np.inf]], np.float32)
    >>> foggy_images(image, depth, straight((1, 2)), (200, 200, 200), [math.log(2) / 100])[0, 0]
    array([[150, 150, 150],
           [200, 200, 200]], dtype=uint8)
    """
    count_zero_depth(depth)
    images = np.empty((len(betas), *image.shape), np.uint8)
    _render(image, depth, rays, airlight, betas, images.reshape(len(betas), -1), False)
    return images


def foggy_scan_lines(
    image: np.ndarray, depth: np.ndarray, rays: Rays, airlight: Sequence[int], betas: Sequence[float], out: np.ndarray
) -> None:
    """The same as scan lines of PNG, for its encoder: each pixel minus the one on its left (filter Sub).

    depth : one that `count_zero_depth` has let through; it is not looked through again
    out : uint8 (B, n), written; n at least (1 + 3 W) H, the rest is left as it is

    Raises ValueError as `foggy_images` does, but for values of depth.
    """
    _render(image, depth, rays, airlight, betas, out, True)


def transmittance_images(
    depth: np.ndarray, rays: Rays, betas: Sequence[float], out: np.ndarray | None = None
) -> np.ndarray:
    """Transmittance at several densities in 8 bits: uint8 (B, H, W), floor(255 t + 0.5).

    Parameters and errors as in `foggy_images`; a beta of 0 gives 255 everywhere.

    >>> from foggy_synscapes.fog.geometry import straight
    >>> transmittance_images(np.array([[0.0, 100.0, np.inf]], np.float32), straight((1, 3)), [math.log(2) / 100])
    array([[[255, 128,   0]]], dtype=uint8)
    """
    from foggy_synscapes.fog import kernel

    count_zero_depth(depth)
    _check(depth.shape, depth, rays, betas)
    shape = (len(betas), *depth.shape)
    levels = np.empty(shape, np.uint8) if out is None else out
    if levels.shape != shape or levels.dtype != np.uint8 or not levels.flags.c_contiguous:
        raise ValueError(f"out: {levels.dtype} {levels.shape}, expected contiguous uint8 {shape}")
    metres = np.ascontiguousarray(depth)
    kernel.render_transmittance(metres, rays.rows, rays.columns, rays.scale, np.array(betas, float), levels)
    return levels


def count_zero_depth(depth: np.ndarray) -> int:
    """How many pixels lie at distance 0, which usually means missing depth; ValueError as in `foggy_images`."""
    from foggy_synscapes.fog import kernel

    if depth.ndim != 2 or depth.dtype != np.float32:
        raise ValueError(f"depth: {depth.dtype} {depth.shape}, expected float32 (H, W)")
    wrong, zero = kernel.survey(depth)
    if wrong:
        raise ValueError(f"depth: {wrong} values are negative or not a number, expected metres")
    return zero


def _render(
    image: np.ndarray,
    depth: np.ndarray,
    rays: Rays,
    airlight: Sequence[int],
    betas: Sequence[float],
    out: np.ndarray,
    filtered: bool,
) -> None:
    # Imported here: Numba takes half a second, and not all that reads this module renders fog.
    from foggy_synscapes.fog import kernel

    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3:
        raise ValueError(f"image: {image.dtype} {image.shape}, expected uint8 (H, W, 3)")
    _check(image.shape[:2], depth, rays, betas)
    light = np.array(airlight, np.uint8)
    if light.shape != (3,):
        raise ValueError(f"airlight: {airlight}, expected three levels")
    pixels, metres = np.ascontiguousarray(image), np.ascontiguousarray(depth)
    size = image.size + len(image) * filtered  # a scan line begins with the number of its filter
    if out.dtype != np.uint8 or out.ndim != 2 or len(out) != len(betas) or out.shape[1] < size:
        raise ValueError(f"out: {out.dtype} {out.shape}, expected uint8 ({len(betas)}, {size}) or more")
    kernel.render(pixels, metres, rays.rows, rays.columns, rays.scale, np.array(betas, float), light, out, filtered)


def _check(shape: tuple[int, ...], depth: np.ndarray, rays: Rays, betas: Sequence[float]) -> None:
    if not shape == depth.shape == rays.shape:
        raise ValueError(f"shapes differ: image {shape}, depth {depth.shape}, camera {rays.shape} (rows, columns)")
    if depth.dtype != np.float32:
        raise ValueError(f"depth: {depth.dtype} {depth.shape}, expected float32 (H, W)")
    for beta in betas:
        if not 0 <= beta < math.inf:
            raise ValueError(f"beta: {beta}, expected a finite number of 1/m that is not negative")


def _attenuation(value: float, name: str) -> float:
    if not 0 < value < math.inf:
        raise ValueError(f"{name}: {value}, expected a finite number above 0")
    return value
