"""The pinhole camera of a frame."""

from dataclasses import dataclass
from math import isfinite


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
        If a number is not finite, or a focal length or size is not above 0.
    """

    fx: float
    fy: float
    u0: float
    v0: float
    resx: int
    resy: int

    def __post_init__(self) -> None:
        for name in ("fx", "fy", "u0", "v0"):
            if not isfinite(getattr(self, name)):
                raise ValueError(f"{name} is {getattr(self, name)}, expected a finite number of pixels")
        for name in ("fx", "fy", "resx", "resy"):
            if getattr(self, name) <= 0:
                raise ValueError(f"{name} is {getattr(self, name)}, expected a number of pixels above 0")
