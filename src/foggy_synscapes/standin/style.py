"""By what a frame is drawn before anything stands in it: random choices, weather and light, texture, colours.

Two kinds of frame. Under a veiled or clouded sky (sky_contrast 2 to 5) the brightest sky is the near-white of the
published samples, so fog made from it is white. Under direct sun (5 to 6) the sky is cloudless and blue: the dark
channel then takes blue for the atmospheric light and the fog turns blue, the failure case of section III of the paper.
"""

import math
from dataclasses import dataclass

import numpy as np

from foggy_synscapes.labels import CLASSES, LABEL_IDS

ID = dict(zip(CLASSES, LABEL_IDS, strict=True))
"""labelId by class name."""

BLUE_EVERY = 9
"""One frame of nine, 11 %, has a blue sky: enough for the filter to matter, few enough to fill the subsets."""


def colour(code: str) -> np.ndarray:
    """Float32 RGB in [0, 1] of a colour in the notation of CSS.

    >>> (colour("ff0033") * 255).tolist()
    [255.0, 0.0, 51.0]
    """
    return np.frombuffer(bytes.fromhex(code), np.uint8).astype(np.float32) / np.float32(255)


@dataclass(frozen=True)
class Weather:
    """sky_contrast (2 to 6), sun_height (0 to 1), direction to the sun, light levels and whether the sky is blue."""

    sky_contrast: float
    sun_height: float
    sun: tuple[float, float, float]
    ambient: float
    direct: float
    blue: bool

    @property
    def glare(self) -> float:
        """How bright the sky is that glass mirrors, 0 to 1."""
        return 0.35 if self.blue else 0.8

    def light(self, x: float, y: float, z: float) -> float:
        """Brightness factor of a surface that faces (x, y, z), a unit vector of the world."""
        towards = max(0.0, x * self.sun[0] + y * self.sun[1] + z * self.sun[2])
        return self.ambient * (0.88 + 0.12 * y) + self.direct * towards


@dataclass(frozen=True)
class Style:
    """Random choices, the strength of fine texture (small in the synthetic domain, larger in the real), weather."""

    rng: np.random.Generator
    grain: float
    weather: Weather

    def pick(self, codes: str) -> np.ndarray:
        """One of several colours, see `colour`; their codes are separated by spaces."""
        choices = codes.split()
        return colour(choices[self.rng.integers(len(choices))])


def is_blue(seed: tuple[int, ...], frame: int) -> bool:
    """Whether a frame (from 0) is one with a blue sky: one of each block of `BLUE_EVERY`, drawn from the seed."""
    block, place = divmod(frame, BLUE_EVERY)
    return int(np.random.default_rng((*seed, 9, block)).integers(BLUE_EVERY)) == place


def sample_weather(rng: np.random.Generator, blue: bool, overcast: bool) -> Weather:
    """Draw the weather; `overcast` keeps to flat white skies, as under fog."""
    height = rng.uniform(0.45, 0.95) if blue else rng.uniform(0.15, 0.95)
    contrast = rng.uniform(5.05, 6.0) if blue else rng.uniform(2.0, 2.6 if overcast else 4.9)
    azimuth, elevation = rng.uniform(-math.pi, math.pi), 0.25 + 0.9 * height
    sun = (math.cos(elevation) * math.sin(azimuth), math.sin(elevation), math.cos(elevation) * math.cos(azimuth))
    clear = min(1.0, max(0.0, (contrast - 2.4) / 2.8))
    ambient, direct = 0.92 - 0.34 * clear, 0.06 + 0.62 * clear
    dim = 0.86 + 0.14 * height
    return Weather(round(contrast, 4), round(height, 4), sun, ambient * dim, direct * dim, blue)
