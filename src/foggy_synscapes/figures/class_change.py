"""Change of each class's IoU against the baseline."""

from typing import TYPE_CHECKING

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.figures.figure import METRICS, RUNS, Figure
from foggy_synscapes.labels import CLASSES
from foggy_synscapes.training.policy import BASELINE

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

    from foggy_synscapes.figures.sources import Sources


def draw(sources: "Sources") -> "Drawing":
    """FoggyError if the baseline of a network has no scores."""
    from foggy_synscapes.figures.scores import class_change

    panels, annotated = {}, 0
    for network, runs in sources.metrics().items():
        if BASELINE not in runs:
            raise FoggyError(
                f"figures: no scores of row {BASELINE} of {network} on {sources.test_set}; evaluate it first"
            )
        annotated = runs[BASELINE]["annotated_classes"]
        ious = {row: [entry["iou"] for entry in run["classes"]] for row, run in runs.items()}
        for row, run in runs.items():
            ious[row].append(run["mean_iou"]["annotated"])
        panels[sources.networks[network]] = {
            row: [None if a is None or b is None else a - b for a, b in zip(values, ious[BASELINE], strict=True)]
            for row, values in ious.items()
            if row != BASELINE
        }
    return class_change(panels, [*CLASSES, f"mean ({annotated} annotated)"], sources.title(), BASELINE)


FIGURE = Figure(
    text="Change of each class's IoU against the baseline C, in points of percent, by row; first seed.",
    inputs=(METRICS,),
    keys=(*RUNS, "scenes.roots"),
    draw=draw,
    of_test_set=True,
)
