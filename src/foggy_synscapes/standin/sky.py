"""Sky, sun and their numbers.

Two kinds of frame. Under a veiled or clouded sky (sky_contrast 2 to 5) the brightest sky is the near-white of the
published samples, so fog made from it is white. Under direct sun (5 to 6) the sky is cloudless and blue: the dark
channel then takes blue for the atmospheric light and the fog turns blue, the failure case of section III of the paper.
"""

import math
from dataclasses import dataclass

import numpy as np

from foggy_synscapes.standin.canvas import FARTHEST, SKY_FAR, SKY_NEAR, Canvas
from foggy_synscapes.standin.noise import upsample
from foggy_synscapes.standin.textures import colour

BRIGHTEST = (251, 255, 249)
"""8-bit RGB of the brightest sky of the published samples."""

BLUE_EVERY = 9
"""One frame of nine, 11 %, has a blue sky: enough for the filter to matter, few enough to fill the subsets."""


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


def is_blue(seed: tuple[int, ...], frame: int) -> bool:
    """Whether a frame (from 0) is one with a blue sky: one of each block of `BLUE_EVERY`, drawn from the seed."""
    block, place = divmod(frame, BLUE_EVERY)
    return int(np.random.default_rng((*seed, 9, block)).integers(BLUE_EVERY)) == place


def sample_weather(rng: np.random.Generator, blue: bool, overcast: bool = False) -> Weather:
    """Draw the weather; `overcast` keeps to flat white skies, as under fog."""
    height = float(rng.uniform(0.45, 0.95) if blue else rng.uniform(0.15, 0.95))
    contrast = float(rng.uniform(5.05, 6.0) if blue else rng.uniform(2.0, 2.6 if overcast else 4.9))
    azimuth, elevation = rng.uniform(-math.pi, math.pi), 0.25 + 0.9 * height
    sun = (math.cos(elevation) * math.sin(azimuth), math.sin(elevation), math.cos(elevation) * math.cos(azimuth))
    clear = min(1.0, max(0.0, (contrast - 2.4) / 2.8))
    ambient, direct = 0.92 - 0.34 * clear, 0.06 + 0.62 * clear
    dim = 0.86 + 0.14 * height
    return Weather(round(contrast, 4), round(height, 4), sun, ambient * dim, direct * dim, blue)


def paint_sky(canvas: Canvas, weather: Weather, rng: np.random.Generator, label: int) -> None:
    """Fill every pixel that nothing else has covered: colour, dome depth and label."""
    open_sky = canvas.depth > FARTHEST
    up = np.clip(canvas.rays[1].ravel()[open_sky], 0, 1)
    canvas.depth[open_sky] = (SKY_NEAR + 60) + (SKY_FAR - SKY_NEAR - 120) * np.minimum(1, 2.5 * up)
    canvas.label[open_sky] = label
    canvas.instance[open_sky] = 0
    white = colour(*BRIGHTEST)
    if weather.blue:
        low, high = colour(172, 205, 246), colour(96, 146, 222)
        part = np.minimum(1, up / 0.32)[:, None]
        canvas.rgb[open_sky] = low * (1 - part) + high * part
        return
    cells = (5, 7) if weather.sky_contrast < 3.4 else (8, 9)
    field = 0.7 * upsample(rng.standard_normal(cells), (canvas.rows, canvas.columns))
    field += 0.3 * upsample(rng.standard_normal((3 * cells[0], 3 * cells[1])), (canvas.rows, canvas.columns))
    field = field.ravel()[open_sky].astype(np.float32)
    if weather.sky_contrast < 3.4:  # overcast: grey swells in the white
        grey = np.clip((field - 0.25) * 0.12 + 0.25 * up, 0, 0.16)
        canvas.rgb[open_sky] = white * (1 - grey)[:, None]
        return
    # Blue gaps only well above the horizon: enough white is always seen for a white atmospheric light.
    height = np.clip((up - 0.07) / 0.08, 0, 1)
    gap = np.clip((field - 0.3) * 1.8, 0, 0.9) * height * min(1.0, (weather.sky_contrast - 2.9) / 1.6)
    blue = colour(142, 186, 228)
    canvas.rgb[open_sky] = white * (1 - gap)[:, None] + blue * gap[:, None]
