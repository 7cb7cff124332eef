"""Figures of scores: change by class, and confusion matrices."""

from collections.abc import Mapping, Sequence

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from foggy_synscapes.figures.style import COLOURS, SETTINGS, new_figure

# Rows differ in the form of their marks as well as in colour, for print in black and white.
MARKS = ("o", "s", "^", "D", "v", "P", "X")
DODGE = 0.75
"""Height that the marks of one class share, in lines."""
SHOWN = 0.05
"""Share of a class's pixels from which a confusion is written into its cell."""


def class_change(
    panels: Mapping[str, Mapping[str, Sequence[float | None]]],
    names: Sequence[str],
    title: str = "",
    baseline: str = "C",
) -> Figure:
    """Dots of the change of IoU against a baseline: a panel per network, a line per class, a mark per row.

    Parameters
    ----------
    panels : by network, then by row: change of each class in points of percent, None where it is undefined
    names : of the classes, from top to bottom; the last one, such as a mean, is set apart
    """
    places = [*range(len(names) - 1), len(names) - 0.5]
    rows = list(dict.fromkeys(row for panel in panels.values() for row in panel))
    with matplotlib.rc_context(SETTINGS):
        figure = new_figure(1.0 + 2.9 * len(panels), 0.2 * len(names) + 1.1)
        axes = figure.subplots(1, len(panels), squeeze=False, sharey=True, sharex=True)[0]
        for panel, (network, changes) in zip(axes, panels.items(), strict=True):
            panel.axvline(0, color="0.3", linewidth=0.8)
            for number, row in enumerate(rows):
                points = [
                    (change, place)
                    for change, place in zip(changes.get(row, ()), places, strict=False)
                    if change is not None
                ]
                # Marks of one class stand a little above each other, so that equal changes stay visible.
                offset = DODGE * ((number + 0.5) / len(rows) - 0.5)
                panel.plot(
                    [change for change, _ in points],
                    [place + offset for _, place in points],
                    linestyle="none",
                    marker=MARKS[number % len(MARKS)],
                    color=COLOURS[number % len(COLOURS)],
                    markersize=4.5,
                    markeredgecolor="white",
                    markeredgewidth=0.4,
                    label=row,
                )
            panel.axhline(len(names) - 1.25, color="0.7", linewidth=0.6)
            panel.set_title(network)
            panel.set_xlabel(f"change of IoU against {baseline} (points)")
            panel.set_yticks(places, names)
            panel.tick_params(axis="y", length=0)
            panel.set_ylim(places[-1] + 0.5, -0.6)
            panel.grid(alpha=0.35, linewidth=0.4)
            panel.set_axisbelow(True)
        handles = dict(zip(*reversed(axes[0].get_legend_handles_labels()), strict=True))
        figure.legend(handles.values(), handles, loc="outside lower center", ncols=min(5, len(rows)), frameon=False)
        if title:
            figure.suptitle(title, fontsize=9)
    return figure


def confusion(panels: Mapping[str, np.ndarray], names: Sequence[str], title: str = "") -> Figure:
    """Confusion matrices side by side: of each class's pixels, the share that is predicted as each class.

    Parameters
    ----------
    panels : by heading: int64 (C, C) or (C, C + 1), labels in rows, predictions in columns, the last as no class
    names : of the C classes
    """
    with matplotlib.rc_context(SETTINGS):
        figure = new_figure(1.2 + 3.9 * len(panels), 5.0)
        axes = figure.subplots(1, len(panels), squeeze=False, sharey=True)[0]
        for panel, (heading, matrix) in zip(axes, panels.items(), strict=True):
            labelled = matrix.sum(axis=1, keepdims=True)
            shares = np.divide(matrix, labelled, out=np.full(matrix.shape, np.nan), where=labelled > 0)
            # An absent class has no shares: its line stays grey.
            panel.set_facecolor("0.8")
            image = panel.imshow(100 * shares, cmap="Blues", vmin=0, vmax=100)
            columns = [*names, "no class"][: matrix.shape[1]]
            panel.set_xticks(range(len(columns)), columns, rotation=90)
            panel.set_yticks(range(len(names)), names)
            panel.spines[:].set_visible(False)
            panel.tick_params(length=0)
            panel.set_title(heading)
            panel.set_xlabel("predicted")
            for row, column in zip(*np.nonzero(np.nan_to_num(shares) >= SHOWN), strict=True):
                share = shares[row, column]
                panel.text(
                    column, row, f"{100 * share:.0f}", ha="center", va="center", fontsize=4.5,
                    color="white" if share > 0.55 else "black",
                )  # fmt: skip
        axes[0].set_ylabel("labelled")
        figure.colorbar(image, ax=axes, label="share of the labelled pixels (%)", shrink=0.6, pad=0.01)
        if title:
            figure.suptitle(title, fontsize=9)
    return figure
