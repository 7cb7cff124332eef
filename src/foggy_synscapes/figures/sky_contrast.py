"""Distribution of the scene key by which the paper would filter, and the filter's cut."""

from collections.abc import Sequence

import numpy as np

from foggy_synscapes.figures.figure import FILTER, Drawing, Figure, Sources
from foggy_synscapes.figures.style import COLOURS, drawing

KEY = "sky_contrast"
BINS = 40


def draw(sources: Sources) -> Drawing:
    """The key is that of the paper's section IV.B."""
    values, kept = sources.filter(KEY)
    cuts = [
        (kind, getattr(rule, kind))
        for rule in sources.params.filter.rules
        for kind in ("minimum", "maximum")
        if rule.key == KEY and getattr(rule, kind) is not None
    ]
    stand_in = " (stand-in)" if sources.drawn("synscapes") else ""
    return cut_histogram(values, kept, cuts, KEY, f"Synscapes{stand_in}: contrast of the sky of each frame")


def cut_histogram(
    values: Sequence[float], kept: Sequence[bool], cuts: Sequence[tuple[str, float]], name: str, title: str = ""
) -> Drawing:
    """Histogram of a property over all frames: those kept and, hatched above them, those left out.

    values : of the property, one per frame; kept : whether the filter kept the frame, by this rule or another
    cuts : ("minimum" or "maximum", value), drawn as lines
    """
    measured, inside = np.asarray(values, float), np.asarray(kept, bool)
    known = np.isfinite(measured)  # a meta file may lack it
    measured, inside = measured[known], inside[known]
    low, high = measured.min(), measured.max()
    width = (high - low) / BINS or 1.0
    # Bins begin at the cut: one that it divides would mix what is kept with what is not.
    start = cuts[0][1] if cuts else low
    edges = start + width * np.arange(np.floor((low - start) / width), np.floor((high - start) / width) + 2)
    with drawing(5.4, 2.6, title) as figure:
        axes = figure.subplots()
        axes.hist(
            [measured[inside], measured[~inside]], edges.tolist(), stacked=True, color=COLOURS[:2], hatch=["", "////"],
            edgecolor="white", linewidth=0.3,
            label=[f"kept: {inside.sum():,} frames", f"left out: {(~inside).sum():,} frames"],
        )  # fmt: skip
        for kind, cut in cuts:
            axes.axvline(cut, color="black", linestyle="--", linewidth=1, label=f"{kind} of the filter: {cut:g}")
        axes.set(xlabel=name, ylabel="frames")
        figure.legend(loc="outside lower center", ncols=3)
    return figure


FIGURE = Figure(
    text="Contrast of the sky over all frames of Synscapes. Values of 5 to 6 are direct sun, which the "
    "filter may leave out.",
    inputs=(FILTER,),
    keys=("filter", "scenes.roots"),
    draw=draw,
)
