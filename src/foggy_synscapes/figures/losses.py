"""Lines of losses over a training."""

from collections.abc import Mapping, Sequence

import matplotlib
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from foggy_synscapes.figures.style import COLOURS, DASHES, SETTINGS, new_figure

Points = Sequence[tuple[float, float]]


def losses(panels: Mapping[str, Mapping[str, tuple[Points, Points]]], title: str = "") -> Figure:
    """Losses over the share of a training that is done: training above, validation below, a column per network.

    Parameters
    ----------
    panels : by network, then by row: points (share in percent, training loss) and (share in percent, validation loss)
    """
    with matplotlib.rc_context(SETTINGS):
        figure = new_figure(3.6 * len(panels), 4.6)
        axes = figure.subplots(2, len(panels), squeeze=False, sharex=True)
        for column, (network, rows) in enumerate(panels.items()):
            for number, (row, losses) in enumerate(rows.items()):
                style = {
                    "color": COLOURS[number % len(COLOURS)],
                    "linestyle": DASHES[number % len(DASHES)],
                    "linewidth": 1.1,
                }
                for panel, points in zip(axes[:, column], losses, strict=True):
                    panel.plot(*zip(*points, strict=True) if points else ([], []), label=row, **style)
                if losses[1]:
                    best = min(losses[1], key=lambda point: point[1])
                    axes[1, column].plot(*best, "o", color=style["color"], markersize=4)
            axes[0, column].set_title(network)
            axes[1, column].set_xlabel("training done (%); dot: the snapshot that is kept")
        for panel, name in zip(axes[:, 0], ("training loss", "validation loss"), strict=True):
            panel.set_ylabel(name)
        for panel in axes.flat:
            panel.set_yscale("log")
            # Plain numbers at every tick: losses stay within a decade or two.
            panel.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
            panel.yaxis.set_minor_formatter(NullFormatter())
            panel.yaxis.set_major_locator(LogLocator(subs=(1, 1.2, 1.5, 2, 3, 4, 5, 6, 8)))
            panel.grid(alpha=0.3, linewidth=0.4)
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False)
        if title:
            figure.suptitle(title, fontsize=9)
    return figure
