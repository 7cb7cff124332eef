"""Confusion matrices are exact counts, however the pixels are split up."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from foggy_synscapes.scoring.confusion import UNKNOWN, VOID, JointHistogram, confusion_matrix, fold, joint_histogram
from foggy_synscapes.scoring.tally import Tally

SIDES = st.tuples(st.integers(1, 12), st.integers(1, 12))


def counted_one_by_one(labels, predictions):
    counts = np.zeros((256, 256), np.int64)
    for label, prediction in zip(labels.ravel(), predictions.ravel(), strict=True):
        counts[label, prediction] += 1
    return counts


def maps(shape, top=255):
    return arrays(np.uint8, shape, elements=st.integers(0, top))


@st.composite
def map_pairs(draw, top=255):
    shape = draw(SIDES)
    return draw(maps(shape, top)), draw(maps(shape, top))


def test_three_classes_worked_by_hand():
    labels = np.array([[0, 0, 1, 1], [2, 2, 255, 1]], np.uint8)
    predictions = np.array([[0, 1, 1, 1], [2, 0, 2, 255]], np.uint8)
    # rows: labels 0, 1, 2; columns: predicted 0, 1, 2, nothing
    assert confusion_matrix(labels, predictions, classes=3).tolist() == [[1, 1, 0, 0], [0, 2, 0, 1], [1, 0, 1, 0]]


@given(map_pairs())
def test_counts_are_those_of_a_plain_loop(pair):
    assert np.array_equal(joint_histogram(*pair), counted_one_by_one(*pair))


@given(map_pairs(top=2), st.integers(1, 9))
@settings(max_examples=50)
def test_chunk_size_does_not_matter(pair, chunk):
    assert np.array_equal(JointHistogram(8 * chunk)(*pair), joint_histogram(*pair))


@pytest.mark.parametrize("runs", [1, 3, 7, 8, 9, 64, 1000])
def test_long_runs_and_noise_are_counted_alike(runs):
    """Both ways of counting, by runs and by pixels, at sizes around the word length."""
    rng = np.random.default_rng(runs)
    for size in (1, 7, 8, 9, 1001):
        labels = np.repeat(rng.integers(0, 256, size), runs)[:size].astype(np.uint8)
        predictions = np.repeat(rng.integers(0, 256, size), runs)[:size].astype(np.uint8)
        assert np.array_equal(joint_histogram(labels, predictions), counted_one_by_one(labels, predictions))


@given(map_pairs(top=18))
def test_splitting_an_image_does_not_matter(pair):
    labels, predictions = pair
    cut = labels.shape[0] // 2
    parts = joint_histogram(labels[:cut], predictions[:cut]) + joint_histogram(labels[cut:], predictions[cut:])
    assert np.array_equal(parts, joint_histogram(labels, predictions))


@given(map_pairs(top=18))
def test_orientation_does_not_matter(pair):
    """Strided and Fortran-ordered arrays are read by position, not by memory."""
    labels, predictions = pair
    assert np.array_equal(joint_histogram(labels.T, predictions.T), joint_histogram(labels, predictions))
    assert np.array_equal(
        joint_histogram(labels[::-1, ::-1], predictions[::-1, ::-1]), joint_histogram(labels, predictions)
    )


@given(st.lists(map_pairs(), min_size=1, max_size=6), st.randoms())
@settings(max_examples=40)
def test_merging_in_any_order_gives_the_same_tally(pairs, random):
    def tallies(order):
        for number in order:
            tally = Tally()
            tally.add(*pairs[number], f"labels/{number}.png", f"predictions/{number}.png")
            yield tally

    def merged(parts):
        total = Tally()
        for part in parts:
            total.merge(part)
        return total

    order = list(range(len(pairs)))
    straight = merged(tallies(order))
    random.shuffle(order)
    shuffled = list(tallies(order))
    nested = merged([merged(shuffled[:2]), merged(shuffled[2:])])
    assert np.array_equal(straight.counts, nested.counts)
    assert (straight.images, straight.labels, straight.predictions) == (
        nested.images,
        nested.labels,
        nested.predictions,
    )


def test_more_pixels_than_32_bits_hold():
    """Sums of large sets stay exact: counts of 2**40 pixels and more."""
    counts = np.zeros((256, 256), np.int64)
    counts[1, 0] = 2**53 + 1
    table = np.array([0, 1] + [UNKNOWN] * 254)
    assert fold(counts, table, table, 2).tolist() == [[0, 0, 0], [2**53 + 1, 0, 0]]


def test_void_labels_are_left_out_and_void_predictions_are_misses():
    counts = np.zeros((256, 256), np.int64)
    counts[0, 9], counts[9, 0], counts[9, 9] = 5, 7, 11
    table = np.array([0] + [UNKNOWN] * 8 + [VOID] + [UNKNOWN] * 246)
    assert fold(counts, table, table, 1).tolist() == [[0, 5]]


@pytest.mark.parametrize("side", ["labels", "predictions"])
def test_unknown_id_is_an_error_that_names_it(side):
    labels, predictions = np.zeros((2, 2), np.uint8), np.zeros((2, 2), np.uint8)
    (labels if side == "labels" else predictions)[1, 1] = 77
    with pytest.raises(ValueError, match=f"{side}: unknown id 77"):
        confusion_matrix(labels, predictions, classes=3)


def test_unknown_prediction_under_a_void_label_is_an_error_too():
    with pytest.raises(ValueError, match="unknown id 3"):
        confusion_matrix(np.array([[255]], np.uint8), np.array([[3]], np.uint8), classes=3)


@pytest.mark.parametrize("other", [np.zeros((2, 3), np.uint8), np.zeros(4, np.uint8)])
def test_other_shape_is_an_error(other):
    with pytest.raises(ValueError, match=r"predictions: shape .* but the labels have \(2, 2\)"):
        joint_histogram(np.zeros((2, 2), np.uint8), other)


def test_other_type_is_an_error():
    with pytest.raises(ValueError, match="labels: int64 values, expected ids in uint8"):
        joint_histogram(np.zeros((2, 2), np.int64), np.zeros((2, 2), np.uint8))


def test_empty_maps_count_nothing():
    assert joint_histogram(np.zeros((0, 4), np.uint8), np.zeros((0, 4), np.uint8)).sum() == 0
