"""Confusion matrix of each network's best row."""

from collections.abc import Mapping, Sequence

import numpy as np

from foggy_synscapes.figures.figure import METRICS, RUNS, Drawing, Figure, Sources
from foggy_synscapes.figures.style import drawing
from foggy_synscapes.labels import CLASSES

SHOWN = 0.05
"""Share of a class's pixels from which a confusion is written into its cell."""


def draw(sources: Sources) -> Drawing:
    """The best row is that of the highest mean IoU over the annotated classes."""
    panels = {}
    for network, runs in sources.metrics().items():
        best = max(runs, key=lambda row: runs[row]["mean_iou"]["annotated"])
        matrix = [*zip(*runs[best]["confusion"], strict=True), runs[best]["unlabelled_predictions"]]
        panels[f"{sources.networks[network]}, {best} (highest mean IoU)"] = np.array(matrix, np.int64).T
    return confusion(panels, CLASSES, sources.title())


def confusion(panels: Mapping[str, np.ndarray], names: Sequence[str], title: str = "") -> Drawing:
    """Confusion matrices side by side: of each class's pixels, the share that is predicted as each class.

    panels : by heading: int64 (C, C) or (C, C + 1), labels in rows, predictions in columns, the last as no class
    names : of the C classes
    """
    with drawing(1.2 + 3.9 * len(panels), 5.0, title) as figure:
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
            panel.set(title=heading, xlabel="predicted")
            for row, column in zip(*np.nonzero(np.nan_to_num(shares) >= SHOWN), strict=True):
                share = shares[row, column]
                ink = "white" if share > 0.55 else "black"
                panel.text(column, row, f"{100 * share:.0f}", ha="center", va="center", fontsize=4.5, color=ink)
        axes[0].set_ylabel("labelled")
        figure.colorbar(image, ax=axes, label="share of the labelled pixels (%)", shrink=0.6, pad=0.01)
    return figure


FIGURE = Figure(
    text="Confusion matrix of each network's best row: share of a labelled class's pixels by predicted class.",
    inputs=(METRICS,),
    keys=(*RUNS, "scenes.roots"),
    draw=draw,
    of_test_set=True,
)
