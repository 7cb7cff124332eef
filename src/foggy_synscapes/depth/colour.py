"""CIE L*a*b* of sRGB images, with the constants of Octave's and MATLAB's toolbox routine rgb2lab."""

import numpy as np

MATRIX = np.array([[0.412453, 0.357580, 0.180423], [0.212671, 0.715160, 0.072169], [0.019334, 0.119193, 0.950227]])
"""From linear sRGB to XYZ (IEC 61966-2-1, to six digits)."""

WHITE = np.array([0.95047, 1.0, 1.08883])
"""XYZ of D65."""


def linear() -> np.ndarray:
    """Light of each of the 256 levels of sRGB, from 0 to 1 (IEC 61966-2-1): float64 (256,)."""
    levels = [level / 255 for level in range(256)]
    return np.array([v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in levels])


def lab(image: np.ndarray) -> np.ndarray:
    """L*, a* and b* of an image uint8 (H, W, 3): float64 (H, W, 3), L* from 0 to 100.

    >>> lab(np.array([[[0, 0, 0], [255, 0, 0]]], np.uint8)).round(1).tolist()
    [[[0.0, 0.0, 0.0], [53.2, 80.1, 67.2]]]
    """
    from foggy_synscapes.depth.kernels.pixels import lab as convert

    out = np.empty(image.shape)
    convert(np.ascontiguousarray(image), linear(), MATRIX / WHITE[:, None], out)
    return out
