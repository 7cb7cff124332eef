"""Figures made of images side by side."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from foggy_synscapes.figures.style import drawing
from foggy_synscapes.labels import CLASSES, IGNORE, PALETTE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLUMN = 2.0
"""Width of one image in inches."""


def colour(train_ids: np.ndarray) -> np.ndarray:
    """Cityscapes colours of a map of trainIds (H, W), ignored pixels black: uint8 (H, W, 3)."""
    table = np.zeros((IGNORE + 1, 3), dtype=np.uint8)
    table[: len(PALETTE)] = PALETTE
    return table[train_ids]


def grid(
    images: Sequence[Sequence[np.ndarray]],
    columns: Sequence[str],
    rows: Sequence[str] = (),
    notes: Sequence[Sequence[str]] = (),
    legend: bool = False,
    title: str = "",
) -> "Figure":
    """Images in rows and columns.

    images : rows of uint8 (H, W, 3); sizes may differ
    columns, rows : titles above the first row and left of the first column
    notes : text in a corner of each image, as `images` is laid out
    legend : whether the colours of the classes are explained below
    """
    shape = [line[0].shape[0] / line[0].shape[1] for line in images]
    width, height = COLUMN * len(columns) + 0.3 * bool(rows), sum(COLUMN * ratio + 0.06 for ratio in shape) + 0.25
    box = {"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 1.2}
    with drawing(width, height + 0.55 * legend + 0.2 * bool(title), title) as figure:
        axes = figure.subplots(len(images), len(columns), squeeze=False, gridspec_kw={"height_ratios": shape})
        figure.set_layout_engine("constrained", w_pad=0.02, h_pad=0.02, wspace=0.01, hspace=0.01)
        for (number, place), panel in np.ndenumerate(axes):
            panel.imshow(images[number][place])
            panel.set(xticks=[], yticks=[])
            panel.spines[:].set_visible(False)
            if number == 0:
                panel.set_title(columns[place])
            if rows and place == 0:
                panel.set_ylabel(rows[number])
            if notes and notes[number][place]:
                text = notes[number][place]
                panel.text(0.985, 0.03, text, transform=panel.transAxes, ha="right", fontsize=6.5, bbox=box)
        if legend:
            _explain_classes(figure, len(columns))
    return figure


def _explain_classes(figure: "Figure", columns: int) -> None:
    from matplotlib.patches import Patch

    patches = [
        Patch(facecolor=value / 255, edgecolor="0.4", linewidth=0.4, label=name)
        for name, value in zip((*CLASSES, "not labelled"), (*PALETTE, np.zeros(3)), strict=True)
    ]
    figure.legend(handles=patches, loc="outside lower center", ncols=min(10, 2 + 2 * columns))
