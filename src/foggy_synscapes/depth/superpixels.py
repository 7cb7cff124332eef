"""SLIC superpixels (Achanta et al., TPAMI 2012), with the constants of the published completion of depth."""

import math

import numpy as np

from foggy_synscapes.depth.colour import linear

WANTED = 2048
"""Superpixels wanted per image (IJCV 2018, section 3.1)."""

COMPACTNESS = 10.0
"""What a step between centres counts in Lab (IJCV 2018, section 3.1)."""


def slic(image: np.ndarray, wanted: int = WANTED) -> tuple[np.ndarray, int]:
    """Segments of an image: labels from 0, int32 (H, W), and how many there are, which may be more or less than wanted.

    image : uint8 (H, W, 3)

    Raises ValueError if there are not four pixels for each segment wanted.

    >>> image = np.zeros((8, 8, 3), np.uint8)
    >>> image[:, 4:] = 200
    >>> slic(image, wanted=4)[0][[0, 0, 7, 7], [0, 7, 0, 7]].tolist()
    [0, 1, 2, 3]
    """
    from foggy_synscapes.depth.kernels import superpixels as kernels

    height, width = image.shape[:2]
    if height * width < 4 * wanted:
        raise ValueError(f"image: {width} x {height} pixels, expected four or more for each of {wanted} superpixels")
    planes = np.empty((3, height, width))
    kernels.lab(np.ascontiguousarray(image), linear(), planes)
    step = int(math.sqrt(height * width / wanted) + 0.5)
    rows, columns = seeds(height, step), seeds(width, step)
    down, across = np.repeat(rows, columns.size), np.tile(columns, rows.size)
    centres = np.concatenate([planes[:, down, across], across[None], down[None]])
    labels = kernels.cluster(planes, step, COMPACTNESS, centres)
    segments = np.empty(labels.shape, np.int32)
    count = kernels.connect(labels, height * width // wanted >> 2, segments)
    return segments, max(count, 1)


def seeds(size: int, step: int) -> np.ndarray:
    """Where the centres begin along one side of so many pixels: in the middle of steps that are stretched to fill it.

    >>> seeds(10, 4).tolist(), seeds(12, 5).tolist()
    ([2, 7], [2, 8])
    """
    strips = int(0.5 + size / step)
    strips -= size < step * strips
    strips = max(strips, 1)
    stretch = (size - step * strips) / strips
    return np.array([min(k * step + step // 2 + int(k * stretch), size - 1) for k in range(strips)])
