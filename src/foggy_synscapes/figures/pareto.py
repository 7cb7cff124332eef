"""Time against error or accuracy, with the Pareto front."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from foggy_synscapes.figures.style import COLOURS, MARKERS, drawing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NONE = 1e-6  # where an error of 0 is drawn

Point = tuple[str, str, float, float, float]  # network, way of computing, scale, time, accuracy


def errors_front(points: Sequence[tuple[str, float, float]], front: Sequence[str], x: str, y: str) -> "Figure":
    """Points (name, time, error) on logarithmic axes; those of `front` are filled and joined."""
    with drawing(5.6, 3.8) as figure:
        axis = figure.subplots()
        axis.set(xscale="log", yscale="log", xlabel=x, ylabel=y)
        axis.grid()
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
                name, place, xytext=(4, -10 if crowded else 4), textcoords="offset points", fontsize=7,
                weight="bold" if chosen else "normal",
            )  # fmt: skip
        axis.axhline(NONE, color="0.6", linewidth=0.8, linestyle=":")
        line = axis.get_yaxis_transform()
        axis.text(0.99, NONE * 1.15, "no change", color="0.4", fontsize=7, ha="right", transform=line)
        axis.set_ylim(NONE / 2, None)
        low, high = axis.get_xlim()
        axis.set_xlim(low, high * 2)  # room for the names
        if best:
            axis.legend(loc="upper right")
        return figure


def accuracy_front(
    points: Sequence[Point], best: Sequence[bool], x: str, y: str, ends: Sequence[tuple[float, float] | None] = ()
) -> "Figure":
    """Points on a logarithmic axis of time: colours for ways, markers for scales, one line for each network and way.

    Points of the front (`best`) have a dark rim and are joined. ends : of the interval of each point's accuracy, drawn
    as a bar where there is one
    """
    from matplotlib.lines import Line2D
    from matplotlib.ticker import FormatStrFormatter, LogFormatter

    networks, ways, scales = (list(dict.fromkeys(point[place] for point in points)) for place in range(3))
    with drawing(6.2, 3.8) as figure:
        axis = figure.subplots()
        axis.set(xscale="log", xlabel=x, ylabel=y)
        axis.grid(which="both")
        joined = sorted((time, accuracy) for (*_, time, accuracy), good in zip(points, best, strict=True) if good)
        axis.step(*zip(*joined, strict=True), where="post", color="0.25", linewidth=1)
        for network in networks:
            for way, colour in zip(ways, COLOURS, strict=False):
                line = [(time, accuracy) for name, kind, _, time, accuracy in points if (name, kind) == (network, way)]
                dashes = "-" if network == networks[0] else "--"
                axis.plot(*zip(*line, strict=True), dashes, color=colour, linewidth=0.8, alpha=0.6)
        for (_, way, scale, time, accuracy), good in zip(points, best, strict=True):
            rim: dict[str, Any] = {"markeredgecolor": "black", "markeredgewidth": 1.1, "markersize": 7}
            plain: dict[str, Any] = {"markeredgecolor": "white", "markeredgewidth": 0.5, "markersize": 6}
            mark, colour = MARKERS[scales.index(scale)], COLOURS[ways.index(way)]
            axis.plot(time, accuracy, mark, color=colour, zorder=3, **(rim if good else plain))
        for (_, way, _, time, _), interval in zip(points, ends, strict=False):
            if interval is not None:
                axis.vlines(time, *interval, color=COLOURS[ways.index(way)], linewidth=0.9, alpha=0.7)
        axis.xaxis.set_major_formatter(FormatStrFormatter("%g"))
        axis.xaxis.set_minor_formatter(LogFormatter(minor_thresholds=(2, 0.6)))
        named: list[dict[str, Any]] = [
            {"color": COLOURS[number], "linewidth": 3, "label": way} for number, way in enumerate(ways)
        ]
        named += [
            {"color": "0.4", "marker": MARKERS[number], "linestyle": "", "label": f"scale {scale:g}"}
            for number, scale in enumerate(scales)
        ]
        named += [
            {"color": "0.4", "linestyle": "--" if number else "-", "linewidth": 0.8, "label": network}
            for number, network in enumerate(networks)
        ]
        named.append({"color": "0.25", "linewidth": 1, "label": "Pareto front"})
        figure.legend(handles=[Line2D([], [], **line) for line in named], loc="outside right center")
        return figure
