"""Arrays as text that a page carries: exact, because no decoder of images or colour profile is involved.

Each value minus the one above it (filter Up of PNG), deflated, in base64. `templates/planes.js` reads them back.
"""

import base64
import math
import zlib
from dataclasses import dataclass

import numpy as np

AT_ZERO, FARTHEST, INFINITE = 0, 65534, 65535
"""Codes of distance 0, of the largest finite distance, and of infinity; the smallest distance above 0 has code 1."""

LEVEL = 6  # effort of deflate; more takes twice as long for 1 %


@dataclass(frozen=True)
class Distances:
    """Distances on 65,534 logarithmic steps.

    codes : uint16 (H, W), AT_ZERO, 1 to FARTHEST, INFINITE
    nearest, farthest : metres of codes 1 and FARTHEST, 0 < nearest <= farthest
    """

    codes: np.ndarray
    nearest: float
    farthest: float

    @property
    def step(self) -> float:
        """Natural logarithm of the ratio of neighbouring distances."""
        return math.log(self.farthest / self.nearest) / (FARTHEST - 1)

    def metres(self) -> np.ndarray:
        """The distances that the codes stand for, float32 (H, W), as the page computes them."""
        table = self.nearest * np.exp(self.step * (np.arange(INFINITE + 1) - 1.0))
        table[AT_ZERO], table[INFINITE] = 0, np.inf
        return table.astype(np.float32)[self.codes]

    def worst(self) -> float:
        """Largest error, in grey levels, that rounding to codes makes in any foggy pixel at any beta.

        With optical depth x = beta l and transmittance t = exp(-x), dt = x exp(-x) dl / l, and x exp(-x) is at most
        1 / e, whatever beta is. A code is off by at most half a step in ln l, and a pixel spans at most 255 levels
        between clear image and airlight: 255 step / (2 e). Distances of float32 span a factor of at most e^192, so the
        bound is below 0.14 for every frame, and below 0.006 for 5 m to 9 km. Two values that are less than 1 apart
        round to levels that are at most 1 apart; the shader's float32 adds less than 0.001 (see the tests).
        """
        return 255 * self.step / (2 * math.e)


def distances(metres: np.ndarray) -> Distances:
    """Distances on logarithmic steps between the smallest and the largest of them.

    metres : float (H, W), along the ray, at least 0, infinity allowed; ValueError for others

    >>> found = distances(np.array([[0.0, 10.0, 1000.0, np.inf]]))
    >>> found.codes.tolist(), found.metres().round(3).tolist()
    ([[0, 1, 65534, 65535]], [[0.0, 10.0, 1000.0, inf]])
    """
    metres = np.asarray(metres, np.float64)
    if metres.ndim != 2 or not (metres >= 0).all():
        raise ValueError("metres: expected distances (H, W), none negative or not a number")
    usual = (metres > 0) & (metres < np.inf)
    known = metres[usual]
    nearest, farthest = (float(known.min()), float(known.max())) if known.size else (1.0, 1.0)
    found = Distances(np.where(metres > 0, INFINITE, AT_ZERO).astype(np.uint16), nearest, farthest)
    steps = np.log(known / nearest) / found.step if farthest > nearest else np.zeros(known.size)
    found.codes[usual] = 1 + np.rint(steps).astype(np.uint16)
    return found


def bytes_text(values: np.ndarray) -> str:
    """Text of uint8 (H, W) or (H, W, C); ValueError for other arrays."""
    if values.dtype != np.uint8 or values.ndim not in (2, 3):
        raise ValueError(f"values: {values.dtype} {values.shape}, expected uint8 (H, W) or (H, W, C)")
    return _text(np.diff(values, axis=0, prepend=np.zeros_like(values[:1])).tobytes())


def words_text(values: np.ndarray) -> str:
    """Text of uint16 (H, W): differences of small size are small numbers, high bytes apart from low ones.

    Raises ValueError for other arrays.
    """
    if values.dtype != np.uint16 or values.ndim != 2:
        raise ValueError(f"values: {values.dtype} {values.shape}, expected uint16 (H, W)")
    difference = np.diff(values, axis=0, prepend=np.zeros_like(values[:1])).view(np.int16)
    folded = ((difference << 1) ^ (difference >> 15)).view(np.uint16)  # 0, -1, 1, -2, ... become 0, 1, 2, 3, ...
    return _text((folded >> 8).astype(np.uint8).tobytes() + (folded & 255).astype(np.uint8).tobytes())


def file_text(data: bytes) -> str:
    """Text of a file, such as a JPEG, as it is."""
    return base64.b64encode(data).decode("ascii")


def _text(data: bytes) -> str:
    return base64.b64encode(zlib.compress(data, LEVEL)).decode("ascii")
