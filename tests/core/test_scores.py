"""Figures of scores show every defined number once, and are the same bytes every time."""

import numpy as np
import pytest

from foggy_synscapes.figures.class_change import class_change
from foggy_synscapes.figures.confusion import confusion
from foggy_synscapes.figures.style import render
from foggy_synscapes.labels import CLASSES

CHANGES = {
    "RefineNet": {"FC": np.array([1.0, np.nan, -2.0, 0.5]), "FS": np.array([0.0, np.nan, 4.0, 1.5])},
    "BiSeNet": {"FS": np.array([3.0, np.nan, 1.0, 2.0])},
}
NAMES = ("road", "train", "bicycle", "mean")
MATRIX = np.hstack([np.diag([10, 0, 30]), [[10], [0], [0]]])


def marks(panel) -> dict[str, list[float]]:
    return {line.get_label(): list(line.get_xdata()) for line in panel.lines if not line.get_label().startswith("_")}


def test_each_defined_change_is_one_mark():
    refinenet, bisenet = class_change(CHANGES, NAMES).axes
    assert marks(refinenet) == {"FC": [1.0, -2.0, 0.5], "FS": [0.0, 4.0, 1.5]}
    assert marks(bisenet) == {"FC": [], "FS": [3.0, 1.0, 2.0]}


def test_marks_stand_on_the_line_of_their_class_in_both_panels():
    for panel in class_change(CHANGES, NAMES).axes:
        places = panel.get_yticks()
        line = next(line for line in panel.lines if line.get_label() == "FS")
        assert np.abs(np.array(line.get_ydata()) - np.array(places)[[0, 2, 3]]).max() < 0.5


def test_rows_differ_in_form_and_colour():
    lines = [line for line in class_change(CHANGES, NAMES).axes[0].lines if not line.get_label().startswith("_")]
    assert len({line.get_marker() for line in lines}) == len({line.get_color() for line in lines}) == 2


def test_confusion_shows_shares_of_the_labelled_pixels():
    panel = confusion({"C": MATRIX}, NAMES[:3]).axes[0]
    image = panel.images[0].get_array()
    assert image[0].tolist() == [50.0, 0.0, 0.0, 50.0]
    assert np.ma.getmaskarray(image)[1].all() or np.isnan(image[1]).all()
    assert sorted(text.get_text() for text in panel.texts) == ["100", "50", "50"]
    assert [label.get_text() for label in panel.get_xticklabels()] == ["road", "train", "bicycle", "no class"]


@pytest.mark.parametrize("ending", ["png", "pdf"])
def test_the_same_scores_give_the_same_bytes(ending):
    rng = np.random.default_rng(0)
    matrix = rng.integers(0, 100, (19, 20))
    for make in (
        lambda: class_change(CHANGES, NAMES, "title"),
        lambda: confusion({"C": matrix, "FS": matrix}, CLASSES),
    ):
        first, second = render(make(), ending), render(make(), ending)
        assert first == second
        assert b"Date" not in first
