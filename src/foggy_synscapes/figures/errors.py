"""Errors of transmittance over optical depth, by number format."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from foggy_synscapes.figures.style import COLOURS, drawing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LOWEST = 1e-18  # where errors of 0 are drawn
INVISIBLE = 6.23  # optical depth from which 255 t rounds to 0


def errors(panels: Mapping[str, Mapping[str, tuple[Sequence[float], Sequence[float]]]]) -> "Figure":
    """Relative error against optical depth, one panel per quantity, one line per way of computing it.

    panels : by quantity, then by name of the way: optical depths and relative errors; ways "FORMAT" and "FORMAT, HOW"
    share a colour, and the last way of a format is dashed where there are several
    """
    with drawing(4.2 * len(panels), 4.0) as figure:
        axes = figure.subplots(1, len(panels), squeeze=False, sharey=True)[0]
        for axis, (quantity, ways) in zip(axes, panels.items(), strict=True):
            last = {name.partition(",")[0]: name for name in ways}
            colours = dict(zip(last, COLOURS, strict=False))
            for name, (depths, found) in ways.items():
                form = name.partition(",")[0]
                dashes = "--" if name == last[form] and len(ways) > len(last) else "-"
                shown = [max(error, LOWEST) for error in found]
                axis.plot(depths, shown, label=name, linewidth=1.1, color=colours[form], linestyle=dashes)
            axis.axvline(INVISIBLE, color="0.6", linewidth=0.8)
            axis.text(INVISIBLE * 1.15, 1e-13, "invisible\nin 8 bits", color="0.4", fontsize=7)
            axis.set(xscale="log", yscale="log", ylim=(LOWEST, 3))
            axis.set(xlabel="optical depth, beta times distance", ylabel=f"relative error of {quantity}")
            axis.grid()
            axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2 if len(ways) > 4 else 4)
        return figure
