"""Number formats in which fog may be computed: NumPy's own, and bfloat16 rounded after each operation."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import torch


@dataclass(frozen=True)
class Format:
    """A binary floating-point format that PyTorch knows by this name; carrier : NumPy type that holds its values."""

    name: str
    carrier: type

    @cached_property
    def info(self) -> "torch.finfo":
        """What PyTorch knows of it: `smallest_normal`, below which precision is lost bit by bit, `max`, `eps`."""
        import torch

        return torch.finfo(getattr(torch, self.name))

    @property
    def unit(self) -> float:
        """Largest relative error of one rounding."""
        return self.info.eps / 2

    @property
    def smallest(self) -> float:
        """Half of it rounds to 0."""
        return self.info.smallest_normal * self.info.eps

    def cast(self, values: object) -> np.ndarray:
        """Values rounded to the format; overflow gives infinity."""
        with np.errstate(over="ignore", under="ignore"):
            held: np.ndarray = np.asarray(values).astype(self.carrier)
            return to_bfloat16(held) if self.name == "bfloat16" else held

    def ulp(self, values: np.ndarray) -> np.ndarray:
        """Distance between neighbours at each float64 value, that of subnormal numbers near 0."""
        with np.errstate(divide="ignore"):
            exponent = np.floor(np.log2(np.abs(values)))
        return 2.0 ** np.maximum(exponent, math.log2(self.info.smallest_normal)) * self.info.eps

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
    import torch

    return torch.tensor(values).to(torch.bfloat16).to(torch.float32).numpy()


FORMATS = (
    Format("float64", np.float64),
    Format("float32", np.float32),
    Format("float16", np.float16),
    Format("bfloat16", np.float32),
)
