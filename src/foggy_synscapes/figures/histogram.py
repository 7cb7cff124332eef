"""How one property of the frames is distributed, and where the filter cuts."""

from collections.abc import Sequence

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from foggy_synscapes.figures.style import COLOURS, SETTINGS, new_figure

BINS = 40


def cut_histogram(
    values: Sequence[float],
    kept: Sequence[bool],
    cuts: Sequence[tuple[str, float]],
    name: str,
    title: str = "",
) -> Figure:
    """Histogram of a property over all frames: those kept and, hatched above them, those left out.

    Parameters
    ----------
    values : of the property, one per frame; kept : whether the filter kept the frame, by this rule or another
    cuts : ("minimum" or "maximum", value), drawn as lines
    """
    measured, inside = np.asarray(values, float), np.asarray(kept, bool)
    low, high = measured.min(), measured.max()
    width = (high - low) / BINS or 1.0
    # Bins begin at the cut: one that it divides would mix what is kept with what is not.
    start = cuts[0][1] if cuts else low
    edges = start + width * np.arange(np.floor((low - start) / width), np.floor((high - start) / width) + 2)
    with matplotlib.rc_context(SETTINGS):
        figure = new_figure(5.4, 2.6)
        axes = figure.subplots()
        labels = [f"kept: {inside.sum():,} frames", f"left out: {(~inside).sum():,} frames"]
        axes.hist(
            [measured[inside], measured[~inside]],
            edges.tolist(),
            stacked=True,
            color=COLOURS[:2],
            hatch=["", "////"],
            edgecolor="white",
            linewidth=0.3,
            label=labels,
        )
        for kind, cut in cuts:
            axes.axvline(cut, color="black", linestyle="--", linewidth=1, label=f"{kind} of the filter: {cut:g}")
        axes.set_xlabel(name)
        axes.set_ylabel("frames")
        figure.legend(loc="outside lower center", ncols=3, frameon=False)
        if title:
            figure.suptitle(title, fontsize=9)
    return figure
