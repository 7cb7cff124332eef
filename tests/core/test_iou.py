"""Scores from confusion matrices: by hand, by both conventions, and by their properties."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from foggy_synscapes.labels import CLASSES
from foggy_synscapes.scoring import iou
from foggy_synscapes.scoring.metrics import check, summarize

# Labels by predictions, the last column predicted as nothing; class 2 is absent from the ground truth.
WORKED = np.array([[50, 10, 5, 5], [20, 80, 0, 0], [0, 0, 0, 0]])
MATRICES = arrays(np.int64, (19, 20), elements=st.integers(0, 50))


def nineteen(**rows):
    """A matrix of 19 classes in which only the given ones, by index as c0, c1, ..., have labelled pixels."""
    matrix = np.zeros((19, 20), np.int64)
    for name, row in rows.items():
        matrix[int(name[1:]), list(row)] = list(row.values())
    return matrix


def test_three_classes_worked_by_hand():
    assert iou.true_positives(WORKED).tolist() == [50, 80, 0]
    assert iou.false_positives(WORKED).tolist() == [20, 10, 5]
    assert iou.false_negatives(WORKED).tolist() == [20, 20, 0]
    scores = iou.iou(WORKED)
    assert scores[:2].tolist() == [50 / 90, 80 / 110]
    assert math.isnan(scores[2])
    assert iou.mean_annotated(scores) == (50 / 90 + 80 / 110) / 2
    assert iou.mean_as_published(scores) == (50 / 90 + 80 / 110) / 3
    assert iou.pixel_accuracy(WORKED) == 130 / 170
    assert iou.frequency_weighted_iou(WORKED) == pytest.approx(70 / 170 * 50 / 90 + 100 / 170 * 80 / 110)


def test_category_confusion_within_is_a_hit():
    scores = iou.category_iou(WORKED, {"both": (0, 1), "third": (2,)})
    # 160 of 170 labelled pixels stay within; nothing outside is predicted as either.
    assert scores == {"both": 160 / 170, "third": 0.0}


def test_absent_class_is_left_out_of_the_mean():
    scores = summarize(nineteen(c0={0: 30, 16: 10}), images=1)
    assert scores["annotated_classes"] == 1
    assert scores["mean_iou"] == {"annotated": 75.0, "as_published": 75.0 / 19}
    assert scores["classes"][16] == {"name": "train", "iou": None, "tp": 0, "fp": 10, "fn": 0}


def test_the_official_mean_counts_a_falsely_predicted_absent_class_as_zero():
    """One pixel decides there: the annotated mean stays, the official one halves."""
    without, with_one = nineteen(c0={0: 30}), nineteen(c0={0: 29, 16: 1})
    assert summarize(without, 1)["mean_iou_cityscapes"] == 100.0
    assert summarize(with_one, 1)["mean_iou_cityscapes"] == pytest.approx(100 * 29 / 30 / 2)
    assert summarize(with_one, 1)["mean_iou"]["annotated"] == pytest.approx(100 * 29 / 30)


def test_prediction_of_nothing_is_a_miss():
    scores = summarize(nineteen(c0={0: 30, 19: 10}), images=1)
    assert scores["classes"][0] == {"name": "road", "iou": 75.0, "tp": 30, "fp": 0, "fn": 10}
    assert scores["unlabelled_predictions"][0] == 10
    assert np.array(scores["confusion"]).shape == (19, 19)


def test_nothing_annotated_is_an_error():
    with pytest.raises(ValueError, match="no pixel of the ground truth is labelled"):
        summarize(np.zeros((19, 20), np.int64), images=3)


def test_other_number_of_classes_is_an_error():
    with pytest.raises(ValueError, match=r"matrix: shape \(3, 4\)"):
        summarize(np.ones((3, 4), np.int64), images=3)


def test_perfect_predictions_score_everywhere_100():
    scores = summarize(np.hstack([np.diag(np.arange(1, 20)), np.zeros((19, 1), np.int64)]), images=2)
    assert {entry["iou"] for entry in scores["classes"]} == {100.0}
    assert scores["mean_iou"] == {"annotated": 100.0, "as_published": 100.0}
    assert scores["pixel_accuracy"] == scores["mean_category_iou"] == 100.0
    assert scores["frequency_weighted_iou"] == pytest.approx(100.0)


@given(MATRICES)
def test_scores_agree_with_their_definitions(matrix):
    scores = iou.iou(matrix)
    for number in range(19):
        hit = int(matrix[number, number])
        labelled = int(matrix[number].sum())
        union = labelled + int(matrix[:, number].sum()) - hit
        if labelled:
            assert scores[number] == hit / union
        else:
            assert math.isnan(scores[number])


@given(MATRICES, st.permutations(range(19)))
def test_renaming_classes_renames_scores(matrix, order):
    renamed = matrix[np.ix_(order, [*order, 19])]
    assert np.array_equal(iou.iou(renamed), iou.iou(matrix)[order], equal_nan=True)


@given(MATRICES, st.integers(1, 1000))
def test_more_of_the_same_changes_nothing(matrix, times):
    assert np.allclose(iou.iou(matrix * times), iou.iou(matrix), equal_nan=True, rtol=1e-15)


@given(MATRICES.filter(np.any))
def test_every_summary_is_accepted_and_within_bounds(matrix):
    scores = summarize(matrix, images=1)
    check(scores)
    assert scores["mean_iou"]["as_published"] <= scores["mean_iou"]["annotated"] + 1e-12
    assert [entry["name"] for entry in scores["classes"]] == list(CLASSES)
    for entry in scores["classes"]:
        assert (entry["iou"] is None) == (entry["tp"] + entry["fn"] == 0)
