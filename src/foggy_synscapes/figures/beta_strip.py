"""Two frames in clear weather and at each beta."""

from foggy_synscapes.figures.figure import FRAMES, Drawing, Figure, Sources
from foggy_synscapes.figures.panels import grid
from foggy_synscapes.fog.optics import meteorological_optical_range
from foggy_synscapes.io.progress import progress

COUNT = 2


def draw(sources: Sources) -> Drawing:
    """As in the paper's figure 3."""
    params = sources.params
    betas = params.figures.betas
    heads = [f"β = {beta} / m, visibility {meteorological_optical_range(float(beta)):.0f} m" for beta in betas]
    frames = progress(sources.frames(COUNT), "figures beta_strip", unit="frame")
    return grid([[frame.clear, *frame.foggy(betas, params.fog)] for frame in frames], ["clear", *heads])


FIGURE = Figure(
    text="Two frames in clear weather and in fog of growing density; visibility is the meteorological "
    "optical range, 2.996 / beta.",
    inputs=(FRAMES,),
    keys=("fog.model", "fog.values", "fog.geometry", "scenes.shards"),
    draw=draw,
)
