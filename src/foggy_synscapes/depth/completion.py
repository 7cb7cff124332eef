"""Depth at every pixel from a stereo pair and its disparity: planes per superpixel. Source: IJCV 2018, section 3.1.

Unreliable disparity is left out; superpixels with enough of the rest get a plane by RANSAC, the others that of the most
similar one; the plane gives depth where none was reliable, and where it is more than 50 m off.
"""

import math
from dataclasses import dataclass

import numpy as np

from foggy_synscapes.camera import Camera
from foggy_synscapes.depth import disparity as measured
from foggy_synscapes.depth.colour import lab
from foggy_synscapes.depth.superpixels import COMPACTNESS, WANTED, slic

SEED = 5489
"""Seed of MT19937 from which the published code's permutations come (MATLAB's default stream)."""


@dataclass(frozen=True)
class Stereo:
    """A rectified stereo pair: `camera` of the left view, `baseline` between both in metres.

    Raises ValueError if the baseline is not a finite number above 0.
    """

    camera: Camera
    baseline: float

    def __post_init__(self) -> None:
        if not 0 < self.baseline < math.inf:
            raise ValueError(f"baseline is {self.baseline}, expected metres above 0")


@dataclass(frozen=True)
class Segments:
    """What became of each of K superpixels.

    labels : int32 (H, W), from 0
    planes : float64 (K, 3), a, b and c of depth = a x + b y + c, x and y from 1, metres; infinite where it is far
    own : bool (K,), whether the plane is from its own pixels
    partners : int32 (K,), from which segment a plane was taken, -1 where it is its own
    order : int64, segments with a partner, in the order in which they were matched
    rounds, inliers : int32 (K,), of RANSAC, 0 where there was none
    draws : random numbers that all of them took
    colours, centroids : mean L*, a*, b*, float64 (K, 3), and column and row from 1, float64 (K, 2)
    """

    labels: np.ndarray
    planes: np.ndarray
    own: np.ndarray
    partners: np.ndarray
    order: np.ndarray
    rounds: np.ndarray
    inliers: np.ndarray
    draws: int
    colours: np.ndarray
    centroids: np.ndarray


@dataclass(frozen=True)
class Completed:
    """Completed depth, planar metres, float64 (H, W), at least 0, infinite where it is far; and what it came from.

    missing, inconsistent : bool (H, W), pixels without disparity, and whose match in the right view is outside of it or
        looks otherwise
    """

    depth: np.ndarray
    missing: np.ndarray
    inconsistent: np.ndarray
    segments: Segments


def complete(
    left: np.ndarray,
    right: np.ndarray,
    stored: np.ndarray,
    stereo: Stereo,
    seed: int = SEED,
    wanted: int = WANTED,
) -> Completed:
    """Complete the depth of a frame.

    Parameters
    ----------
    left, right : uint8 (H, W, 3)
    stored : disparity of the left view as Cityscapes stores it, uint16 (H, W)
    stereo : of these images
    seed : of the random permutations, 0 to 2^32 - 1; `wanted` : number of superpixels

    Raises ValueError if shapes or types differ, the image is too small, or no superpixel has enough reliable disparity.
    """
    from foggy_synscapes.depth.kernels import planes as kernels

    _check(left, right, stored, stereo, seed)
    missing, inconsistent = stored == 0, measured.inconsistent(left, right, stored)
    unreliable = missing | inconsistent
    depth = measured.depth(stored, stereo.baseline, stereo.camera.fx)
    labels, count = slic(left, wanted)
    begin, rows, columns = kernels.pixels_of_segments(labels, count)
    planes, states = np.zeros((count, 3)), np.zeros(count, np.uint8)
    rounds, inliers = np.zeros((2, count), np.int32)
    pixels = begin, rows, columns
    draws = kernels.fit_segments(depth, unreliable, *pixels, np.uint32(seed), planes, states, rounds, inliers)
    own = states != kernels.UNSEEN
    if not own.any():
        needed = f"{kernels.LEAST_KNOWN} pixels, and {kernels.LEAST_SHARE:.0%} of its own, of reliable disparity"
        raise ValueError(
            f"disparity: none of {count} superpixels has {needed}; {_share(missing)} have none, {_share(inconsistent)} "
            "look otherwise in the right image"
        )
    colours, centroids, partners, order = match_segments(left, pixels, own)
    for k in order:
        planes[k] = planes[partners[k]]
        inside = slice(begin[k], begin[k + 1])
        kernels.fill(depth, unreliable, rows[inside], columns[inside], planes[k])
    segments = Segments(labels, planes, own, partners, order, rounds, inliers, draws, colours, centroids)
    return Completed(depth, missing, inconsistent, segments)


def match_segments(
    image: np.ndarray, pixels: tuple[np.ndarray, ...], own: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Colours, centroids, partners and order of `Segments`.

    image : uint8 (H, W, 3); pixels : of the segments, see `kernels.planes.pixels_of_segments`; own : as in `Segments`
    """
    from foggy_synscapes.depth.kernels import matching as kernels

    count = own.size
    colours, centroids, partners = np.empty((count, 3)), np.empty((count, 2)), np.empty(count, np.int32)
    kernels.segment_means(lab(image), *pixels, colours, centroids)
    nearness = COMPACTNESS**2 * count / (image.shape[0] * image.shape[1])  # a step between centres counts as much
    order = kernels.match(colours, centroids, own, nearness, partners)
    return colours, centroids, partners, order


def _check(left: np.ndarray, right: np.ndarray, stored: np.ndarray, stereo: Stereo, seed: int) -> None:
    for name, image in (("left", left), ("right", right)):
        if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3 or image.size == 0:
            raise ValueError(f"{name}: {image.dtype} {image.shape}, expected uint8 (H, W, 3)")
    if stored.dtype != np.uint16 or stored.ndim != 2:
        raise ValueError(f"disparity: {stored.dtype} {stored.shape}, expected uint16 (H, W)")
    camera = stereo.camera.resy, stereo.camera.resx
    if not left.shape[:2] == right.shape[:2] == stored.shape == camera:
        shapes = f"left {left.shape[:2]}, right {right.shape[:2]}, disparity {stored.shape}, camera {camera}"
        raise ValueError(f"shapes differ: {shapes} (rows, columns)")
    if not 0 <= seed < 2**32:
        raise ValueError(f"seed: {seed}, expected a whole number from 0 to 2^32 - 1")


def _share(mask: np.ndarray) -> str:
    return f"{mask.mean():.1%} of the pixels"
