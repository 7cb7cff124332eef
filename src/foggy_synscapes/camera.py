"""The pinhole camera of a frame."""

from dataclasses import dataclass

NEAREST, FARTHEST = 1e-3, 1e9
"""Pixels between which numbers of a camera lie: their squares, with those of its columns, keep apart in float64."""


@dataclass(frozen=True)
class Camera:
    """Intrinsic parameters of a pinhole camera, in pixels.

    Parameters
    ----------
    fx, fy : focal lengths along columns and rows, above 0
    u0, v0 : principal point, column and row
    resx, resy : width and height of the image

    Raises
    ------
    ValueError
        If a focal length is not from 1e-3 to 1e9, a principal point not within 1e9, or a size no whole number above 0.
    """

    fx: float
    fy: float
    u0: float
    v0: float
    resx: int
    resy: int

    def __post_init__(self) -> None:
        for name in ("fx", "fy"):
            if not NEAREST <= getattr(self, name) <= FARTHEST:
                raise ValueError(f"{name} is {getattr(self, name)}, expected pixels from {NEAREST:g} to {FARTHEST:g}")
        for name in ("u0", "v0"):
            if not abs(getattr(self, name)) <= FARTHEST:
                raise ValueError(f"{name} is {getattr(self, name)}, expected a number of pixels within {FARTHEST:g}")
        for name in ("resx", "resy"):
            if not (getattr(self, name) > 0 and getattr(self, name) % 1 == 0):
                raise ValueError(f"{name} is {getattr(self, name)}, expected a whole number of pixels above 0")
