"""Number formats in which fog may be computed: NumPy's own, and bfloat16 rounded after each operation."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Format:
    """A binary floating-point format.

    precision : bits of the significand, the hidden one included; lowest, highest : exponents of the smallest and the
    largest normal number; carrier : NumPy type that holds its values
    """

    name: str
    precision: int
    lowest: int
    highest: int
    carrier: type
    rounding: Callable[[np.ndarray], np.ndarray]

    @property
    def unit(self) -> float:
        """Largest relative error of one rounding."""
        return 2.0**-self.precision

    @property
    def smallest_normal(self) -> float:
        """Below it precision is lost bit by bit."""
        return 2.0**self.lowest

    @property
    def smallest(self) -> float:
        """Half of it rounds to 0."""
        return 2.0 ** (self.lowest - self.precision + 1)

    @property
    def largest(self) -> float:
        """Largest finite number."""
        return (2 - 2.0 ** (1 - self.precision)) * 2.0**self.highest

    def cast(self, values: object) -> np.ndarray:
        """Values rounded to the format; overflow gives infinity."""
        with np.errstate(over="ignore", under="ignore"):
            return self.rounding(np.asarray(values).astype(self.carrier))

    def ulp(self, values: np.ndarray) -> np.ndarray:
        """Distance between neighbours at each float64 value, that of subnormal numbers near 0."""
        with np.errstate(divide="ignore"):
            exponent = np.floor(np.log2(np.abs(values)))
        return 2.0 ** (np.maximum(exponent, self.lowest) - self.precision + 1)

    def transmittance(self, distance: np.ndarray, beta: np.ndarray) -> np.ndarray:
        """exp(-beta distance), rounded after each operation."""
        with np.errstate(all="ignore"):
            return self.cast(np.exp(-self.cast(self.cast(beta) * self.cast(distance))))

    def levels(self, t: np.ndarray, clear: np.ndarray | float, airlight: np.ndarray | float) -> np.ndarray:
        """8-bit fog, floor(255 F + 0.5), rounded after each operation; values of the format in, uint8 out."""
        full, half, one = (self.cast(value) for value in (255.0, 0.5, 1.0))
        scaled = [self.cast(self.cast(value) / full) for value in (clear, airlight)]
        with np.errstate(all="ignore"):
            parts = self.cast(t * scaled[0]), self.cast(self.cast(one - t) * scaled[1])
            radiance = self.cast(parts[0] + parts[1])
            level = np.floor(self.cast(self.cast(full * radiance) + half))
            return np.clip(np.nan_to_num(level.astype(np.float64)), 0, 255).astype(np.uint8)


def to_bfloat16(values: np.ndarray) -> np.ndarray:
    """Round float32 to the nearest bfloat16, ties to even; still stored as float32.

    >>> to_bfloat16(np.array([1.0, 1.001, 1.01, np.inf], np.float32)).tolist()
    [1.0, 1.0, 1.0078125, inf]
    """
    bits = values.view(np.uint32).astype(np.uint64)
    rounded = ((bits + 0x7FFF + ((bits >> 16) & 1)) & 0xFFFF0000).astype(np.uint32)
    return np.where(np.isfinite(values), rounded.view(np.float32), values)


def _as_it_is(values: np.ndarray) -> np.ndarray:
    return values


FORMATS = (
    Format("float64", 53, -1022, 1023, np.float64, _as_it_is),
    Format("float32", 24, -126, 127, np.float32, _as_it_is),
    Format("float16", 11, -14, 15, np.float16, _as_it_is),
    Format("bfloat16", 8, -126, 127, np.float32, to_bfloat16),
)
