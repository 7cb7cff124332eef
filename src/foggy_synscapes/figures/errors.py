"""Errors of transmittance over optical depth, by number format."""

from collections.abc import Mapping, Sequence

import matplotlib
from matplotlib.figure import Figure

from foggy_synscapes.figures.style import COLOURS, SETTINGS, new_figure

LOWEST = 1e-18  # where errors of 0 are drawn
INVISIBLE = 6.23  # optical depth from which 255 t rounds to 0


def errors(panels: Mapping[str, Mapping[str, tuple[Sequence[float], Sequence[float]]]]) -> Figure:
    """Relative error against optical depth, one panel per quantity, one line per way of computing it.

    panels : by quantity, then by name of the way: optical depths and relative errors; ways "FORMAT" and "FORMAT, HOW"
    share a colour, and the last way of a format is dashed where there are several
    """
    with matplotlib.rc_context(SETTINGS):
        figure = new_figure(4.2 * len(panels), 4.0)
        axes = figure.subplots(1, len(panels), squeeze=False, sharey=True)[0]
        for axis, (quantity, ways) in zip(axes, panels.items(), strict=True):
            formats = list(dict.fromkeys(name.partition(",")[0] for name in ways))
            for name, (depths, found) in ways.items():
                form = name.partition(",")[0]
                last = [other for other in ways if other.partition(",")[0] == form][-1]
                dashed = name == last and len(ways) > len(formats)
                style = {"color": COLOURS[formats.index(form)], "linestyle": "--" if dashed else "-"}
                axis.plot(depths, [max(error, LOWEST) for error in found], label=name, linewidth=1.1, **style)
            axis.axvline(INVISIBLE, color="0.6", linewidth=0.8)
            axis.text(INVISIBLE * 1.15, 1e-13, "invisible\nin 8 bits", color="0.4", fontsize=7)
            axis.set(xscale="log", yscale="log", ylim=(LOWEST, 3))
            axis.set_xlabel("optical depth, beta times distance")
            axis.set_ylabel(f"relative error of {quantity}")
            axis.grid(alpha=0.3, linewidth=0.4)
            columns = 2 if len(ways) > 4 else 4
            axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), frameon=False, ncols=columns)
        return figure
