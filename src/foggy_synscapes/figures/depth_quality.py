"""Fog by true depth, by depth completed from a simulated stereo camera, and how far they are apart."""

import numpy as np

from foggy_synscapes.depth import refinement
from foggy_synscapes.depth.simulation import completed
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.figures.figure import FRAMES, Drawing, Figure, Sources
from foggy_synscapes.figures.panels import grid
from foggy_synscapes.fog.airlight import estimate
from foggy_synscapes.fog.geometry import rays

COUNT = 3
SHOWN = 60
"""Levels of difference that are drawn as white."""


def draw(sources: Sources) -> Drawing:
    """FoggyError if a frame's depth cannot be completed."""
    params = sources.params
    stereo, beta = params.stereo, params.fog.betas[0]
    images, notes = [], []
    for frame in sources.frames(COUNT):
        true = frame.foggy([beta], params.fog)[0]
        try:
            depth = completed(
                frame.clear, frame.depth, frame.camera, stereo.errors(), (stereo.seed, frame.number), stereo.superpixels
            )
        except ValueError as error:
            raise FoggyError(f"frame {frame.number}: {error}") from error
        t = refinement.guided(frame.clear)(
            refinement.initial(depth, rays(frame.camera, params.fog.geometry), float(beta))
        )
        other = refinement.composite(frame.clear, t, estimate(frame.clear).levels)
        apart = np.abs(other.astype(np.int16) - true).mean(axis=2)
        images.append([frame.clear, true, other, _heat(apart)])
        notes.append(["", "", "", f"mean {apart.mean():.1f} levels"])
    heads = ["clear", "by true depth", "by completed depth", f"difference, white: {SHOWN} levels"]
    return grid(images, heads, notes=notes, title=f"Fog at β = {beta} / m by true depth and by depth from stereo")


def _heat(levels: np.ndarray) -> np.ndarray:
    """Black over red and yellow to white: uint8 (H, W, 3)."""
    share = np.clip(levels / SHOWN, 0, 1)[..., None] * 3 - np.arange(3)
    return np.floor(255 * np.clip(share, 0, 1) + 0.5).astype(np.uint8)


FIGURE = Figure(
    text="Fog by true depth, by depth completed from a simulated stereo camera, and their difference.",
    inputs=(FRAMES,),
    keys=("fog.betas", "fog.geometry", "fog.model", "fog.values", "scenes.shards", "stereo"),
    draw=draw,
    asked="stereo",
)
