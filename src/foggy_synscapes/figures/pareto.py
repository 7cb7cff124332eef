"""Time against error, with the Pareto front."""

from collections.abc import Sequence

import matplotlib
from matplotlib.figure import Figure

from foggy_synscapes.figures.style import COLOURS, SETTINGS, new_figure

NONE = 1e-6  # where an error of 0 is drawn


def pareto(points: Sequence[tuple[str, float, float]], front: Sequence[str], x: str, y: str) -> Figure:
    """Points (name, time, error) on logarithmic axes; those of `front` are filled and joined."""
    with matplotlib.rc_context(SETTINGS):
        figure = new_figure(5.6, 3.8)
        axis = figure.subplots()
        axis.set(xscale="log", yscale="log", xlabel=x, ylabel=y)
        axis.grid(alpha=0.3, linewidth=0.4)
        places = {name: (time, max(error, NONE)) for name, time, error in points}
        best = sorted(places[name] for name in front)
        if best:
            axis.step(*zip(*best, strict=True), where="post", color=COLOURS[0], linewidth=1, label="Pareto front")
        taken: list[tuple[float, float]] = []
        for name, place in places.items():
            chosen = name in front
            # Names of points that lie on one another stand above and below.
            crowded = any(place[1] == y and 0.7 < place[0] / x < 1.4 for x, y in taken)
            taken.append(place)
            colour = COLOURS[0] if chosen else "0.45"
            axis.plot(*place, "o", color=colour, markerfacecolor=colour if chosen else "white", markersize=5)
            axis.annotate(
                name,
                place,
                xytext=(4, -10 if crowded else 4),
                textcoords="offset points",
                fontsize=7,
                weight="bold" if chosen else "normal",
            )
        axis.axhline(NONE, color="0.6", linewidth=0.8, linestyle=":")
        axis.text(
            0.99, NONE * 1.15, "no change", color="0.4", fontsize=7, ha="right", transform=axis.get_yaxis_transform()
        )
        axis.set_ylim(NONE / 2, None)
        low, high = axis.get_xlim()
        axis.set_xlim(low, high * 2)  # room for the names
        if best:
            axis.legend(frameon=False, loc="upper right")
        return figure
