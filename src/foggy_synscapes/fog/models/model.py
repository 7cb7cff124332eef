"""What a model of fog offers: arrays in, arrays out."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from foggy_synscapes.fog.geometry import Rays
from foggy_synscapes.fog.models.settings import Settings

Images = Callable[[np.ndarray, np.ndarray, Rays, Sequence[int], Sequence[float]], np.ndarray]
"""From image uint8 (H, W, 3), planar depth float32 (H, W) in metres, rays, airlight (three levels) and betas in 1/m:
foggy images uint8 (B, H, W, 3)."""
Transmittances = Callable[[np.ndarray, Rays, Sequence[float]], np.ndarray]
"""From depth, rays and betas: transmittance in 8 bits, uint8 (B, H, W)."""
ScanLines = Callable[
    [np.ndarray, np.ndarray, Rays, Sequence[int], Sequence[float]], Callable[[slice, np.ndarray], None]
]
"""From the same as `Images`: a function that writes some rows as scan lines of PNG, see `optics.foggy_scan_lines`."""


@dataclass(frozen=True)
class Choice:
    """A model that another one chose for a frame at one beta: its spelling with all values, and the reason in words."""

    model: str
    why: str


Choose = Callable[[np.ndarray, np.ndarray, Rays, Sequence[int], float], Choice]
"""From the same as `Images`, at one beta."""


@dataclass(frozen=True)
class FogModel:
    """A model of fog.

    text : what it assumes, in one line
    images : puts fog on an image; transmittances : what it lets through, for maps
    scan_lines : the same as `images`, row by row for the encoder, where the model has it; images are encoded otherwise
    settings : its values, each with unit, range and default; configure : the model at values other than the defaults
    choose : which other model it takes for a frame, where it is one that chooses

    All raise ValueError as `optics.foggy_images` does.
    """

    text: str
    images: Images
    transmittances: Transmittances
    scan_lines: ScanLines | None = None
    settings: type[Settings] = Settings
    configure: Callable[[Any], "FogModel"] | None = None
    choose: Choose | None = None


def with_settings(model: FogModel, settings: Settings) -> FogModel:
    """The model at these values; where they are the defaults the model itself, so that nothing is wrapped."""
    if settings == model.settings():
        return model
    found = model.configure(settings) if model.configure is not None else model
    if settings.airlight == "estimated":
        return found
    images, lines = found.images, found.scan_lines

    def lit(
        image: np.ndarray, depth: np.ndarray, rays: Rays, light: Sequence[int], betas: Sequence[float]
    ) -> np.ndarray:
        return images(image, depth, rays, settings.light(light), betas)

    def lit_lines(
        image: np.ndarray, depth: np.ndarray, rays: Rays, light: Sequence[int], betas: Sequence[float]
    ) -> Callable[[slice, np.ndarray], None]:
        assert lines is not None
        return lines(image, depth, rays, settings.light(light), betas)

    return replace(found, images=lit, scan_lines=lit_lines if lines is not None else None)
