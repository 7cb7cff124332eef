"""The airlight (atmospheric light) of an image: one colour, estimated from its haziest pixels by the dark channel.

Source: He, Sun and Tang, Single Image Haze Removal Using Dark Channel Prior, 2011; the published code takes,
of the 0.1 % of pixels with the largest dark channel, one whose grey value is their median.
"""

from dataclasses import dataclass

import numpy as np

WINDOW = 15
"""Pixels, side of the square in which the dark channel takes its minimum."""

SHARE = 1000
"""One candidate per so many pixels."""

GREY = (298936021, 587043074, 114020904)
"""Weights of red, green and blue times 1e9, those of the published code; integers, so that ties are exact."""

BLUE_EXCESS = 0.1
"""Airlight is blue where blue exceeds red by more than this share of the brightest channel.

Overcast skies have a correlated colour temperature of 6,000 to 7,500 K and clear blue skies of more than 10,000 K
(Wyszecki and Stiles, Color Science, 1982). Blackbodies in sRGB have an excess of 0.04 at 7,000 K, 0.11 at 8,000 K and
0.20 at 10,000 K (Planck, CIE 1931 observer). The real samples, with clouds, have -0.01: (251, 255, 249).
"""


@dataclass(frozen=True)
class Airlight:
    """Airlight: its levels, 0 to 255, and the pixel that it was taken from, counted from 0."""

    red: int
    green: int
    blue: int
    row: int
    column: int

    @property
    def levels(self) -> tuple[int, int, int]:
        """Red, green and blue."""
        return self.red, self.green, self.blue

    def is_blue(self) -> bool:
        """Whether it is the light of a cloudless sky, which tints the fog (paper, section III, failure case).

        >>> Airlight(251, 255, 249, 12, 961).is_blue(), Airlight(150, 190, 235, 0, 0).is_blue()
        (False, True)
        """
        return self.blue - self.red > BLUE_EXCESS * max(self.levels)

    def grey(self) -> "Airlight":
        """The same grey value without colour, from the same pixel.

        >>> Airlight(150, 190, 235, 0, 0).grey().levels
        (183, 183, 183)
        """
        level = (sum(weight * value for weight, value in zip(GREY, self.levels, strict=True)) + 500_000_000) // 10**9
        return Airlight(level, level, level, self.row, self.column)


def dark_channel(image: np.ndarray) -> np.ndarray:
    """Smallest channel of the 15 x 15 pixels around each pixel, as far as they lie in the image: uint8 (H, W).

    image : uint8 (H, W, 3)

    >>> image = np.full((1, 20, 3), 9, np.uint8)
    >>> image[0, 10, 1] = 4
    >>> dark_channel(image)[0].tolist()
    [9, 9, 9, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 9, 9]
    """
    from foggy_synscapes.fog import dark_channel as haze

    dark = np.empty(image.shape[:2], np.uint8)
    haze.dark_channel(np.ascontiguousarray(image), WINDOW // 2, dark)
    return dark


def estimate(image: np.ndarray) -> Airlight:
    """Estimate the airlight of an image.

    Of N pixels, c = N // 1000 or one more, so that c is odd, are candidates: those with the largest dark channel,
    ties by column first and then by row. The result is the first of them whose grey value is their median.

    image : uint8 (H, W, 3)

    Raises ValueError if the array has another shape or type, or no pixel.

    >>> image = np.zeros((2, 2, 3), np.uint8)
    >>> image[1, 0] = 50, 60, 70
    >>> estimate(image)            # the dark channel is 0 everywhere: the first pixel of the first column
    Airlight(red=0, green=0, blue=0, row=0, column=0)
    """
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3 or image.size == 0:
        raise ValueError(f"image: {image.dtype} {image.shape}, expected uint8 (H, W, 3)")
    rows, columns = candidates(image)
    grey = image[rows, columns].astype(np.int64) @ np.array(GREY)
    median = np.partition(grey, grey.size // 2)[grey.size // 2]
    first = int(np.argmax(grey == median))
    row, column = int(rows[first]), int(columns[first])
    red, green, blue = (int(level) for level in image[row, column])
    return Airlight(red, green, blue, row, column)


def candidates(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns of the candidates, by dark channel descending, then column, then row: int64.

    image : uint8 (H, W, 3)

    >>> image = np.zeros((20, 20, 3), np.uint8)
    >>> image[3:18, 4:19] = 5                    # 15 x 15 pixels: only the square around the middle one is full
    >>> rows, columns = candidates(image)
    >>> rows.tolist(), columns.tolist()
    ([10], [11])
    """
    from foggy_synscapes.fog import dark_channel as haze

    wanted = image.shape[0] * image.shape[1] // SHARE
    rows, columns = np.empty((2, wanted + (wanted + 1) % 2), np.int64)
    haze.haziest(np.ascontiguousarray(image), WINDOW // 2, rows, columns)
    return rows, columns
