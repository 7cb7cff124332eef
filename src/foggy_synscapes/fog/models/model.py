"""What a model of fog offers: arrays in, arrays out."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from foggy_synscapes.fog.geometry import Rays

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
class FogModel:
    """A model of fog.

    text : what it assumes, in one line
    images : puts fog on an image; transmittances : what it lets through, for maps
    scan_lines : the same as `images`, row by row for the encoder, where the model has it; images are encoded otherwise

    All raise ValueError as `optics.foggy_images` does.
    """

    text: str
    images: Images
    transmittances: Transmittances
    scan_lines: ScanLines | None = None
