"""Light through homogeneous fog: transmittance, visibility, and fog composited on 8-bit images.

F(x) = t(x) R(x) + (1 - t(x)) L with t(x) = exp(-beta l(x)): R clear radiance, L airlight (atmospheric light), l
distance along the ray. Source: Koschmieder 1924; paper, equations (1) and (2).
"""

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from foggy_synscapes.fog.geometry import Rays

if TYPE_CHECKING:
    from foggy_synscapes.fog.renderer import Renderer

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


def lighter_than_fog(beta: float) -> str | None:
    """What to warn of where an attenuation coefficient in 1/m is below the lightest fog's; None for fog, and for 0.

    >>> lighter_than_fog(0.002)
    'beta 0.002 1/m is a visibility of 1,498 m: fog is what lowers it below 1 km, at beta >= 0.002996 (section III)'
    """
    if beta == 0 or beta >= LIGHTEST:
        return None
    return (
        f"beta {beta:g} 1/m is a visibility of {meteorological_optical_range(beta):,.0f} m: fog is what lowers it "
        f"below 1 km, at beta >= {LIGHTEST:g} (section III)"
    )


DENSEST = 0.1
"""1/m, a visibility of 30 m: fog in which nobody drives or records; more is often a slip of a digit."""


def denser_than_usual(beta: float) -> str | None:
    """What to ask where an attenuation coefficient in 1/m is above the densest fog's; None otherwise.

    >>> denser_than_usual(0.2)
    'beta 0.2 1/m is a visibility of 15 m; did you mean 0.02, 150 m?'
    """
    if beta <= DENSEST:
        return None
    sight, likely = meteorological_optical_range(beta), beta
    while likely > DENSEST:
        likely /= 10
    return (
        f"beta {beta:g} 1/m is a visibility of {sight:.3g} m; did you mean {likely:g}, "
        f"{meteorological_optical_range(likely):.3g} m?"
    )


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
    renderer, pixels, metres = _prepared(image, depth, rays, airlight, betas)
    images = np.empty((len(betas), *image.shape), np.uint8)
    renderer.render(pixels, metres, rays.rows, images.reshape(len(betas), image.size), filtered=False)
    return images


def foggy_scan_lines(
    image: np.ndarray, depth: np.ndarray, rays: Rays, airlight: Sequence[int], betas: Sequence[float]
) -> Callable[[slice, np.ndarray], None]:
    """The same as scan lines of PNG, for its encoder: a function that renders some rows.

    It takes a slice of rows, and an array uint8 (B, n) to whose beginning it writes them, one line after the other.
    A scan line is the number of its filter (Sub) and each pixel minus the one on its left: 1 + 3 W bytes.

    depth : one that `count_zero_depth` has let through; it is not looked through again

    Raises ValueError as `foggy_images` does, but for values of depth; the function where the array has no room.
    """
    renderer, pixels, metres = _prepared(image, depth, rays, airlight, betas)
    line = 1 + 3 * image.shape[1]

    def draw(wanted: slice, out: np.ndarray) -> None:
        rows = rays.rows[wanted]
        if out.dtype != np.uint8 or out.ndim != 2 or len(out) != len(betas) or out.shape[1] < len(rows) * line:
            raise ValueError(f"out: {out.dtype} {out.shape}, expected uint8 ({len(betas)}, {len(rows) * line}) or more")
        part = np.ascontiguousarray(pixels[wanted]), np.ascontiguousarray(metres[wanted]), np.ascontiguousarray(rows)
        renderer.render(*part, out, filtered=True)

    return draw


def transmittance_images(depth: np.ndarray, rays: Rays, betas: Sequence[float]) -> np.ndarray:
    """Transmittance at several densities in 8 bits: uint8 (B, H, W), floor(255 t + 0.5).

    Parameters and errors as in `foggy_images`; a beta of 0 gives 255 everywhere.

    >>> from foggy_synscapes.fog.geometry import straight
    >>> transmittance_images(np.array([[0.0, 100.0, np.inf]], np.float32), straight((1, 3)), [math.log(2) / 100])
    array([[[255, 128,   0]]], dtype=uint8)
    """
    white = np.full((*depth.shape, 3), 255, np.uint8)
    return foggy_images(white, depth, rays, (0, 0, 0), betas)[..., 0].copy()  # 255 t: white in dark fog


def count_zero_depth(depth: np.ndarray) -> int:
    """How many pixels lie at distance 0, which usually means missing depth; ValueError as in `foggy_images`."""
    if depth.ndim != 2 or depth.dtype != np.float32:
        raise ValueError(f"depth: {depth.dtype} {depth.shape}, expected float32 (H, W)")
    if depth.min(initial=math.inf) > 0:
        return 0
    right = depth >= 0
    wrong = depth.size - np.count_nonzero(right)
    if wrong:
        row, column = np.unravel_index(np.argmin(right), depth.shape)
        raise ValueError(
            f"depth: {wrong} values are negative or not a number, expected metres; the first is {depth[row, column]} "
            f"at row {row}, column {column}"
        )
    return depth.size - int(np.count_nonzero(depth))


def check_frame(
    image: np.ndarray, depth: np.ndarray, rays: Rays, airlight: Sequence[int], betas: Sequence[float]
) -> np.ndarray:
    """The airlight as uint8 (3,); ValueError as in `foggy_images`, but for values of depth."""
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3 or image.size == 0:
        raise ValueError(f"image: {image.dtype} {image.shape}, expected uint8 (H, W, 3)")
    _check(image.shape[:2], depth, rays, betas)
    light = np.array(airlight, np.uint8)
    if light.shape != (3,):
        raise ValueError(f"airlight: {airlight}, expected three levels")
    return light


def _prepared(
    image: np.ndarray, depth: np.ndarray, rays: Rays, airlight: Sequence[int], betas: Sequence[float]
) -> tuple["Renderer", np.ndarray, np.ndarray]:
    # Imported here: Numba takes half a second, and not all that reads this module renders fog.
    from foggy_synscapes.fog.renderer import Renderer

    light = check_frame(image, depth, rays, airlight, betas)
    renderer = Renderer(rays.columns, rays.scale, np.array(betas, float), light)
    return renderer, np.ascontiguousarray(image), np.ascontiguousarray(depth)


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
