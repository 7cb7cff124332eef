"""Transmittance from completed depth, refined so that its steps lie where the image has them.

Two ways: the guided filter with the image as guide (IJCV 2018, section 3.2), and the dual-reference cross-bilateral
filter with the image and a semantic annotation (ECCV 2018, section 3).
"""

from collections.abc import Callable

import numpy as np

from foggy_synscapes.depth.colour import lab
from foggy_synscapes.fog.geometry import Rays
from foggy_synscapes.fog.optics import transmittance

RADIUS, EPSILON = 20, 1e-3
"""Guided filter: half of a side of 41 pixels, and regularisation where colours are from 0 to 1 (IJCV 2018)."""

SPACING, RANGE, SHARE = 20, 0.1, 5.0
"""Bilateral filter: standard deviations and sizes of cells, in pixels and in Lab / 100, and the weight of the reference
colour against that of labels (ECCV 2018)."""

Refine = Callable[[np.ndarray], np.ndarray]
"""Refines one map of transmittance, float64 (H, W), for an image that it was made for."""

LEVELS = np.arange(256) / 255


def initial(depth: np.ndarray, rays: Rays, beta: float) -> np.ndarray:
    """Transmittance before refinement, float64 (H, W), at an attenuation coefficient in 1/m.

    depth : float64 (H, W), planar metres, at least 0; infinity gives 0

    Raises ValueError as `fog.optics.transmittance` does.
    """
    return transmittance(depth * rays.factor(), beta)


def guided(image: np.ndarray) -> Refine:
    """The guided filter whose guide is an image, uint8 (H, W, 3). What it gives is cut off to 0 to 1.

    >>> refine = guided(np.full((4, 4, 3), 90, np.uint8))
    >>> halves = np.repeat([[0.0, 0.0, 1.0, 1.0]], 4, axis=0)
    >>> bool((abs(refine(halves)[:, 1:3] - 0.5) < 0.03).all())     # the guide shows no step: nearly the mean
    True
    """
    from foggy_synscapes.depth.kernels import guided as kernels

    image = np.ascontiguousarray(image)
    found = np.empty((image.shape[0], kernels.MOMENTS, image.shape[1]))
    kernels.moments(image, LEVELS, RADIUS, EPSILON, found)

    def refine(values: np.ndarray) -> np.ndarray:
        out = np.empty(values.shape)
        kernels.apply(image, LEVELS, found, RADIUS, np.ascontiguousarray(values), out)
        return np.clip(out, 0.0, 1.0, out=out)

    return refine


def bilateral(image: np.ndarray, labels: np.ndarray) -> Refine:
    """The dual-reference cross-bilateral filter of an image, uint8 (H, W, 3), and labels from 0, int32 (H, W).

    Source of labels: `annotation.labels`. What it gives is a weighted mean, so nothing has to be cut off.

    Raises ValueError if sizes differ.
    """
    from foggy_synscapes.depth.kernels import bilateral as kernels

    if labels.shape != image.shape[:2]:
        raise ValueError(f"labels: {labels.shape}, but the image has {image.shape[:2]} (rows, columns)")
    colour = lab(image) / 100
    colour[..., 1:] -= colour[..., 1:].min(axis=(0, 1))
    lowest, highest = colour.min(axis=(0, 1)), colour.max(axis=(0, 1))
    counts = np.floor((highest - lowest) / RANGE).astype(np.int64) + 1 + 2 * kernels.PAD
    kinds = int(labels.max()) + 1

    def refine(values: np.ndarray) -> np.ndarray:
        out = np.empty(values.shape)
        grids = colour, lowest, (int(counts[0]), int(counts[1]), int(counts[2])), labels, kinds
        kernels.apply(*grids, np.ascontiguousarray(values), SPACING, RANGE, SHARE, out)
        return out

    return refine


def composite(image: np.ndarray, values: np.ndarray, airlight: tuple[int, int, int]) -> np.ndarray:
    """Fog on an image by a map of transmittance: uint8 (H, W, 3), each value floor(255 F + 0.5).

    F = t R + (1 - t) L in float64, R and L levels / 255. Source: Koschmieder 1924.

    image : uint8 (H, W, 3); values : t, float64 (H, W), 0 to 1; airlight : three levels

    >>> composite(np.full((1, 1, 3), 100, np.uint8), np.array([[0.25]]), (200, 200, 200)).tolist()
    [[[175, 175, 175]]]
    """
    from foggy_synscapes.depth.kernels.pixels import composite as mix

    out = np.empty(image.shape, np.uint8)
    mix(np.ascontiguousarray(image), values, LEVELS, np.array(airlight) / 255, out)
    return out


def levels(values: np.ndarray) -> np.ndarray:
    """A map of transmittance in 8 bits, uint8 (H, W): floor(255 t + 0.5).

    >>> levels(np.array([[0.0, 0.5, 1.0]]))
    array([[  0, 128, 255]], dtype=uint8)
    """
    return np.floor(255 * values + 0.5).astype(np.uint8)
