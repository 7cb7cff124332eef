"""Depth where a map of it has holes, from the image: planes per superpixel as in completion from stereo.

The published completion takes from the right view only which disparity to leave out. Where depth was measured another
way, what is missing is known, and the same planes and matches fill it. What was measured stays as it is.
"""

import numpy as np

from foggy_synscapes.depth.completion import SEED, match_segments
from foggy_synscapes.depth.superpixels import WANTED, slic

MEASURED = 64
"""Measured pixels that a superpixel should have on average: a plane needs 20, so most get one."""


def fill(image: np.ndarray, depth: np.ndarray, seed: int = SEED) -> np.ndarray:
    """Depth at every pixel, float64 (H, W), planar metres, at least 0.

    Where few pixels are measured, as by a laser scanner, superpixels are larger than the published ones. For a plane of
    its own a superpixel needs 20 measured pixels, and 60 % of the share that the whole image has.

    Parameters
    ----------
    image : uint8 (H, W, 3)
    depth : float64 (H, W), planar metres, at least 0; not a number where it is missing, infinite where it is far
    seed : of the random permutations, 0 to 2^32 - 1

    Raises ValueError if shapes differ, or no superpixel has enough measured depth.

    >>> image = np.full((40, 40, 3), 90, np.uint8)
    >>> slope = np.tile(np.linspace(10, 20, 40), (40, 1))
    >>> holes = slope.copy()
    >>> holes[5:9, 5:9] = np.nan
    >>> bool(np.allclose(fill(image, holes), slope))
    True
    """
    from foggy_synscapes.depth.kernels import planes as kernels

    if image.shape[:2] != depth.shape or image.ndim != 3:
        raise ValueError(f"shapes differ: image {image.shape[:2]}, depth {depth.shape} (rows, columns)")
    missing = np.isnan(depth)
    measured = depth.size - int(np.count_nonzero(missing))
    if not missing.any():
        return depth.copy()
    share, wanted = measured / depth.size, max(1, min(WANTED, int(measured // MEASURED)))
    found = np.where(missing, np.inf, depth)
    labels, count = slic(image, wanted)
    pixels = kernels.pixels_of_segments(labels, count)
    planes, states, counts = np.zeros((count, 3)), np.zeros(count, np.uint8), np.zeros((2, count), np.int32)
    least = kernels.LEAST_SHARE * share
    kernels.fit_segments(found, missing, *pixels, np.uint32(seed), planes, states, *counts, least)
    own = states != kernels.UNSEEN
    if not own.any():
        raise ValueError(
            f"{measured} of {depth.size} pixels have depth, and none of {count} superpixels has {kernels.LEAST_KNOWN} "
            "of them: too few to complete the rest"
        )
    begin, rows, columns = pixels
    _, _, partners, order = match_segments(image, pixels, own)
    for k in order:
        planes[k] = planes[partners[k]]
        inside = slice(begin[k], begin[k + 1])
        kernels.fill(found, missing, rows[inside], columns[inside], planes[k])
    return np.where(missing, found, depth)
