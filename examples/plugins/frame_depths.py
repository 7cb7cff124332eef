"""A figure: the first kept frames of Synscapes, and below each its depth, bright where it is near.

This file's name is the figure's name: it is written to `results/figures/frame_depths.png` and `.pdf`. A figure that
says `of_test_set=True` is drawn once for each test set.
"""

from typing import TYPE_CHECKING

import numpy as np

from foggy_synscapes.figures.figure import FRAMES, Figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

    from foggy_synscapes.figures.sources import Sources

HALF = 20.0
"""Metres at which a pixel is half as bright as one at 0."""


def draw(sources: "Sources") -> "Drawing":
    """`sources` reads what `inputs` below asks for, and no more."""
    from foggy_synscapes.figures.panels import grid

    frames = sources.frames(sources.params.figures.images)
    near = [np.rint(255 / (1 + frame.depth / HALF)).astype(np.uint8) for frame in frames]
    depths = [np.repeat(levels[..., None], 3, axis=2) for levels in near]
    return grid([[frame.clear for frame in frames], depths], [f"frame {frame.number}" for frame in frames])


FIGURE = Figure(
    text="Frames of Synscapes, and below each its depth: white is near, 20 m half as bright, the sky black.",
    inputs=(FRAMES,),
    keys=("scenes.shards",),
    draw=draw,
)
