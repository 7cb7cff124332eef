"""Change of each class's IoU against the baseline."""

from collections.abc import Mapping, Sequence

import numpy as np

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.figures.figure import METRICS, RUNS, Drawing, Figure, Sources
from foggy_synscapes.figures.style import COLOURS, MARKERS, drawing
from foggy_synscapes.labels import CLASSES
from foggy_synscapes.training.policy import BASELINE

DODGE = 0.75
"""Height that the marks of one class share, in lines."""


def draw(sources: Sources) -> Drawing:
    """FoggyError if the baseline of a network has no scores."""
    panels, annotated = {}, 0
    for network, runs in sources.metrics().items():
        if BASELINE not in runs:
            raise FoggyError(
                f"figures: no scores of row {BASELINE} of {network} on {sources.test_set}; evaluate it first"
            )
        annotated = runs[BASELINE]["annotated_classes"]
        ious = {
            row: np.array([*(entry["iou"] for entry in run["classes"]), run["mean_iou"]["annotated"]], float)
            for row, run in runs.items()
        }
        baseline = ious.pop(BASELINE)
        panels[sources.networks[network]] = {row: values - baseline for row, values in ious.items()}
    return class_change(panels, [*CLASSES, f"mean ({annotated} annotated)"], sources.title(), BASELINE)


def class_change(
    panels: Mapping[str, Mapping[str, np.ndarray]], names: Sequence[str], title: str = "", baseline: str = BASELINE
) -> Drawing:
    """Dots of the change of IoU against a baseline: a panel per network, a line per class, a mark per row.

    panels : by network, then by row: change of each class in points of percent, NaN where it is undefined
    names : of the classes, from top to bottom; the last one, such as a mean, is set apart
    """
    places = np.array([*range(len(names) - 1), len(names) - 0.5])
    rows = list(dict.fromkeys(row for panel in panels.values() for row in panel))
    with drawing(1.0 + 2.9 * len(panels), 0.2 * len(names) + 1.1, title) as figure:
        axes = figure.subplots(1, len(panels), squeeze=False, sharey=True, sharex=True)[0]
        for panel, (network, changes) in zip(axes, panels.items(), strict=True):
            panel.axvline(0, color="0.3", linewidth=0.8)
            for number, row in enumerate(rows):
                change = changes.get(row, np.full(len(names), np.nan))
                known = ~np.isnan(change)
                # Marks of one class stand a little above each other, so that equal changes stay visible.
                offset = DODGE * ((number + 0.5) / len(rows) - 0.5)
                panel.plot(
                    change[known], (places + offset)[known], linestyle="none", marker=MARKERS[number % len(MARKERS)],
                    color=COLOURS[number % len(COLOURS)], markersize=4.5, markeredgecolor="white", markeredgewidth=0.4,
                    label=row,
                )  # fmt: skip
            panel.axhline(len(names) - 1.25, color="0.7", linewidth=0.6)
            panel.set(title=network, xlabel=f"change of IoU against {baseline} (points)", axisbelow=True)
            panel.set_yticks(places, names)
            panel.tick_params(axis="y", length=0)
            panel.set_ylim(places[-1] + 0.5, -0.6)
            panel.grid(alpha=0.35)
        handles = dict(zip(*reversed(axes[0].get_legend_handles_labels()), strict=True))
        figure.legend(handles.values(), handles, loc="outside lower center", ncols=min(5, len(rows)))
    return figure


FIGURE = Figure(
    text="Change of each class's IoU against the baseline C, in points of percent, by row; first seed.",
    inputs=(METRICS,),
    keys=(*RUNS, "scenes.roots"),
    draw=draw,
    of_test_set=True,
)
