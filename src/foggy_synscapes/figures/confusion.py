"""Confusion matrix of each network's best row."""

from typing import TYPE_CHECKING

import numpy as np

from foggy_synscapes.figures.figure import METRICS, RUNS, Figure
from foggy_synscapes.labels import CLASSES

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

    from foggy_synscapes.figures.sources import Sources


def draw(sources: "Sources") -> "Drawing":
    """The best row is that of the highest mean IoU over the annotated classes."""
    from foggy_synscapes.figures.scores import confusion

    panels = {}
    for network, runs in sources.metrics().items():
        best = max(runs, key=lambda row: runs[row]["mean_iou"]["annotated"])
        matrix = [*zip(*runs[best]["confusion"], strict=True), runs[best]["unlabelled_predictions"]]
        panels[f"{sources.networks[network]}, {best} (highest mean IoU)"] = np.array(matrix, np.int64).T
    return confusion(panels, CLASSES, sources.title())


FIGURE = Figure(
    text="Confusion matrix of each network's best row: share of a labelled class's pixels by predicted class.",
    inputs=(METRICS,),
    keys=(*RUNS, "scenes.roots"),
    draw=draw,
    of_test_set=True,
)
