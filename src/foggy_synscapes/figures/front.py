"""Time against accuracy of networks, with the Pareto front."""

from collections.abc import Sequence

import matplotlib
import matplotlib.ticker
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from foggy_synscapes.figures.style import COLOURS, SETTINGS, new_figure

MARKERS = ("o", "s", "^", "D", "v", "P", "X")

Point = tuple[str, str, float, float, float]  # network, way of computing, scale, time, accuracy


def front(points: Sequence[Point], best: Sequence[bool], x: str, y: str) -> Figure:
    """Points on a logarithmic axis of time: colours for ways, markers for scales, one line for each network and way.

    Points of the front (`best`) have a dark rim and are joined.
    """
    ways = list(dict.fromkeys(point[1] for point in points))
    scales = list(dict.fromkeys(point[2] for point in points))
    networks = list(dict.fromkeys(point[0] for point in points))
    with matplotlib.rc_context(SETTINGS):
        figure = new_figure(6.2, 3.8)
        axis = figure.subplots()
        axis.set(xscale="log", xlabel=x, ylabel=y)
        axis.grid(alpha=0.3, linewidth=0.4, which="both")
        joined = sorted((time, accuracy) for (*_, time, accuracy), good in zip(points, best, strict=True) if good)
        axis.step(*zip(*joined, strict=True), where="post", color="0.25", linewidth=1)
        for network in networks:
            for way in ways:
                line = [(time, accuracy) for name, kind, _, time, accuracy in points if (name, kind) == (network, way)]
                dashes = "-" if network == networks[0] else "--"
                axis.plot(*zip(*line, strict=True), dashes, color=COLOURS[ways.index(way)], linewidth=0.8, alpha=0.6)
        for (_, way, scale, time, accuracy), good in zip(points, best, strict=True):
            axis.plot(
                time,
                accuracy,
                MARKERS[scales.index(scale)],
                color=COLOURS[ways.index(way)],
                markeredgecolor="black" if good else "white",
                markeredgewidth=1.1 if good else 0.5,
                markersize=7 if good else 6,
                zorder=3,
            )
        axis.xaxis.set_major_formatter(matplotlib.ticker.FormatStrFormatter("%g"))
        axis.xaxis.set_minor_formatter(matplotlib.ticker.LogFormatter(minor_thresholds=(2, 0.6)))
        handles = [Line2D([], [], color=COLOURS[number], linewidth=3, label=way) for number, way in enumerate(ways)]
        handles += [
            Line2D([], [], color="0.4", marker=MARKERS[number], linestyle="", label=f"scale {scale:g}")
            for number, scale in enumerate(scales)
        ]
        handles += [
            Line2D([], [], color="0.4", linestyle="-" if not number else "--", linewidth=0.8, label=network)
            for number, network in enumerate(networks)
        ]
        handles.append(Line2D([], [], color="0.25", linewidth=1, label="Pareto front"))
        figure.legend(handles=handles, loc="outside right center", frameon=False)
        return figure
