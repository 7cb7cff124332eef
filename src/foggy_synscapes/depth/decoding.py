"""From the values of a depth file to metres: units, disparity, codes in colours, and which pixels have none."""

import math
from dataclasses import dataclass

import numpy as np

PLANAR, RAY, DISPARITY = "planar", "ray", "disparity"
MEANINGS = (PLANAR, RAY, DISPARITY)
"""What a value is: metres to the image plane, metres along the ray, or pixels between both views."""

PLAIN, RGB24 = "plain", "rgb24"
CODES = (PLAIN, RGB24)
"""How a value is stored: as itself, or in 24 bits, the lowest in red and the highest in blue (CARLA)."""
HIGHEST = 2**24 - 1


@dataclass(frozen=True)
class Encoding:
    """What the values v of a depth file mean: (v - offset) scale, in metres or, of a disparity, in pixels.

    scale : metres or pixels per unit, above 0; None where the file has to hold metres (pixels) as floating point
    offset : in stored units; meaning : one of MEANINGS; code : one of CODES
    missing : stored value of pixels without depth, beside values that are negative or not a number
    far : stored value from which on a pixel is infinitely far, such as the sky's

    Raises ValueError if a number is out of range, or a name unknown.
    """

    scale: float | None = None
    offset: float = 0.0
    meaning: str = PLANAR
    code: str = PLAIN
    missing: float = 0.0
    far: float = math.inf

    def __post_init__(self) -> None:
        if self.scale is not None and not 0 < self.scale < math.inf:
            raise ValueError(f"scale is {self.scale}, expected a number above 0")
        if not math.isfinite(self.offset):
            raise ValueError(f"offset is {self.offset}, expected a number")
        if self.meaning not in MEANINGS or self.code not in CODES:
            raise ValueError(f"{self.meaning}, {self.code}: expected {', '.join(MEANINGS)} and {', '.join(CODES)}")


METRES = Encoding()
"""Planar metres in floating point."""


def decode(stored: np.ndarray, encoding: Encoding, fx: float = 0.0, baseline: float = 0.0) -> np.ndarray:
    """Depth in metres, float64 (H, W): not a number where there is none, infinite where a pixel is infinitely far.

    A disparity of 0 is infinitely far, unless 0 is stored where there is none.

    Parameters
    ----------
    stored : numbers (H, W), or uint8 (H, W, 3) where the code is RGB24
    encoding : what they mean
    fx, baseline : focal length in pixels and metres between both views, above 0; of a disparity

    Raises ValueError if the array is of another shape or type, its unit is not stated, or focal length or baseline are
    needed and not above 0.

    >>> decode(np.array([[0, 1500]], np.uint16), Encoding(scale=0.001)).tolist()           # millimetres
    [[nan, 1.5]]
    >>> cityscapes = Encoding(scale=1 / 256, offset=1, meaning=DISPARITY)
    >>> decode(np.array([[0, 1, 513]], np.uint16), cityscapes, 400.0, 0.5).tolist()
    [[nan, inf, 100.0]]
    >>> decode(np.array([[[255, 255, 255]]], np.uint8), Encoding(1000 / HIGHEST, code=RGB24)).tolist()   # CARLA
    [[1000.0]]
    """
    values = _plain(stored, encoding)
    units = "pixels of disparity" if encoding.meaning == DISPARITY else "metres"
    if encoding.scale is None and values.dtype.kind != "f":
        raise ValueError(
            f"holds {values.dtype}, whose unit it does not tell. Give {units} per unit by --depth-scale, e.g. 0.001 "
            "for millimetres, 0.01 for centimetres, 1/256 for KITTI"
        )
    numbers = values.astype(np.float64)
    found = (numbers - encoding.offset) * (1.0 if encoding.scale is None else encoding.scale)
    with np.errstate(invalid="ignore"):
        # A disparity of 0 is far where 0 is stored otherwise; no measured one is infinite.
        none = (numbers == encoding.missing) | ~(found >= 0)
        if encoding.meaning == DISPARITY:
            if not (fx > 0 and baseline > 0):
                raise ValueError(f"disparity needs a focal length and a baseline above 0, got {fx} and {baseline}")
            none |= np.isinf(found)
            found = np.divide(fx * baseline, found, out=np.full(found.shape, np.inf), where=found > 0)
        found[numbers >= encoding.far] = np.inf
    found[none] = np.nan
    return found


def _plain(stored: np.ndarray, encoding: Encoding) -> np.ndarray:
    if encoding.code == RGB24:
        if stored.dtype != np.uint8 or stored.ndim != 3 or stored.shape[2] != 3:
            raise ValueError(f"holds {stored.dtype} {stored.shape}, expected depth in the three colours of 8 bits")
        return stored.astype(np.int64) @ np.array([1, 256, 65536])
    if stored.ndim != 2 or stored.dtype.kind not in "fiu" or stored.size == 0:
        colours = stored.ndim == 3 and stored.dtype == np.uint8
        hint = "; is it depth in colours, --depth-code rgb24, or a picture of depth?" if colours else ""
        raise ValueError(f"holds {stored.dtype} {stored.shape}, expected one number for each pixel{hint}")
    return stored
