"""By what a frame is drawn before anything stands in it: random choices, weather and light, colours, noise.

Two kinds of frame. Under a veiled or clouded sky (sky_contrast 2 to 5) the brightest sky is the near-white of the
published samples, so fog made from it is white. Under direct sun (5 to 6) the sky is cloudless and blue: the dark
channel then takes blue for the airlight and the fog turns blue, the failure case of section III of the paper.
"""

import math
from dataclasses import dataclass

import numpy as np

from foggy_synscapes.labels import CLASSES, LABEL_IDS

ID = dict(zip(CLASSES, LABEL_IDS, strict=True))
"""labelId by class name."""

BLUE_EVERY = 9
"""One frame of nine, 11 %, has a blue sky: enough for the filter to matter, few enough to fill the subsets."""


def palette(codes: str) -> np.ndarray:
    """Float32 RGB (N, 3) in [0, 1] of colours in the notation of CSS, separated by spaces.

    >>> (palette("ff0033 000000") * 255).tolist()
    [[255.0, 0.0, 51.0], [0.0, 0.0, 0.0]]
    """
    return np.frombuffer(bytes.fromhex(codes), np.uint8).reshape(-1, 3).astype(np.float32) / np.float32(255)


def colour(code: str) -> np.ndarray:
    """One colour, see `palette`."""
    return palette(code)[0]


@dataclass(frozen=True)
class Weather:
    """sky_contrast (2 to 6), sun_height (0 to 1), direction to the sun, light levels and whether the sky is blue."""

    sky_contrast: float
    sun_height: float
    sun: tuple[float, float, float]
    ambient: float
    direct: float
    blue: bool
    glare: float  # how bright the sky is that glass mirrors, 0 to 1

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
        """One of several colours, see `palette`."""
        colours = palette(codes)
        return colours[self.rng.integers(len(colours))]


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
    return Weather(round(contrast, 4), round(height, 4), sun, ambient * dim, direct * dim, blue, 0.35 if blue else 0.8)


_SIDE = 256


def _octaves() -> np.ndarray:
    rng = np.random.default_rng(20190)
    field = np.zeros((_SIDE, _SIDE))
    for cells, weight in ((8, 0.9), (32, 0.7), (128, 0.6), (256, 0.5)):
        field += weight * upsample(rng.standard_normal((cells, cells)), (_SIDE, _SIDE), wrap=True)
    return np.clip(field / (1.6 * field.std()), -1, 1).astype(np.float32)


def upsample(coarse: np.ndarray, size: tuple[int, int], wrap: bool = False) -> np.ndarray:
    """Stretch an array (h, w) to `size` (rows, columns) with smooth (cubic step) blending between its values."""
    for axis, length in enumerate(size):
        cells = coarse.shape[axis]
        place = np.arange(length) / length * (cells if wrap else cells - 1)
        low = np.floor(place).astype(int)
        part = place - low
        part = part * part * (3 - 2 * part)
        part = part[:, None] if axis == 0 else part[None, :]
        coarse = coarse.take(low, axis) * (1 - part) + coarse.take((low + 1) % cells, axis) * part
    return coarse


NOISE = _octaves()
"""float32 (256, 256) in [-1, 1], tileable."""


def noise(u: np.ndarray, v: np.ndarray, scale: float = 1.0) -> np.ndarray:
    """Noise at surface coordinates, metres; `scale` in cells per metre."""
    rows, columns = ((place * np.float32(scale)).astype(np.int32) & (_SIDE - 1) for place in (u, v))
    return NOISE[rows, columns]
