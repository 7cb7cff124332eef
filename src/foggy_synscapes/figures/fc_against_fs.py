"""Foggy Synscapes above Foggy Cityscapes at the same beta."""

from foggy_synscapes.figures.figure import FRAMES, REFINED, Drawing, Figure, Sources
from foggy_synscapes.figures.panels import grid


def draw(sources: Sources) -> Drawing:
    """As in the paper's figure 4."""
    params = sources.params
    beta, count = params.figures.comparison_beta, params.figures.images
    above = [frame.foggy([beta], params.fog)[0] for frame in sources.frames(count)]
    below = sources.refined(beta, count)
    shown = min(len(above), len(below))
    title = f"β = {beta} / m on exact depth (above), on completed disparity (below)"
    return grid([above[:shown], below[:shown]], [""] * shown, ["Foggy Synscapes", "Foggy Cityscapes"], title=title)


FIGURE = Figure(
    text="Fog at the same beta from exact depth (Foggy Synscapes) and from completed stereo depth (Foggy Cityscapes).",
    inputs=(FRAMES, REFINED),
    keys=("fog.model", "fog.values", "fog.geometry", "scenes.refined_list", "scenes.shards"),
    draw=draw,
)
