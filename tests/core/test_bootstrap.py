"""Intervals of differences of mean IoU: paired, as wide as they have to be, and none of a single image."""

import numpy as np
import pytest

from foggy_synscapes.scoring.bootstrap import in_words, interval, mean_iou
from foggy_synscapes.scoring.iou import iou, mean_annotated

CLASSES, PIXELS = 5, 400


def drawn_images(rng: np.random.Generator, count: int, right: float, other: float) -> tuple[np.ndarray, np.ndarray]:
    """Two models on images of uneven difficulty, which both share."""
    both = []
    labelled = rng.multinomial(PIXELS, [1 / CLASSES] * CLASSES, size=count)
    hard = rng.uniform(-0.2, 0.2, (count, 1))
    for share in (right, other):
        hits = rng.binomial(labelled, np.clip(share + hard, 0, 1))
        matrices = np.zeros((count, CLASSES, CLASSES + 1), np.int64)
        matrices[:, range(CLASSES), range(CLASSES)] = hits
        matrices[:, range(CLASSES), np.roll(range(CLASSES), 1)] = labelled - hits
        both.append(matrices)
    return both[0], both[1]


def test_mean_iou_is_that_of_the_tables():
    matrices = np.random.default_rng(0).integers(0, 50, (7, 19, 20))
    matrices[:, 16] = 0
    expected = [100 * mean_annotated(iou(matrix)) for matrix in matrices]
    np.testing.assert_allclose(mean_iou(matrices), expected, rtol=1e-12)


def test_equal_models_differ_by_nothing():
    one, _ = drawn_images(np.random.default_rng(0), 12, 0.7, 0.7)
    assert interval(one, one) == (0.0, 0.0)


def test_an_interval_is_the_same_each_time_and_turns_with_the_order():
    one, two = drawn_images(np.random.default_rng(1), 20, 0.7, 0.6)
    low, high = interval(one, two)
    assert (low, high) == interval(one, two)
    assert high < 0
    np.testing.assert_allclose(interval(two, one), (-high, -low))


def test_of_one_image_there_is_no_interval():
    one, two = drawn_images(np.random.default_rng(2), 1, 0.7, 0.6)
    assert interval(one, two) is None


def test_other_images_are_refused():
    one, two = drawn_images(np.random.default_rng(3), 4, 0.7, 0.6)
    with pytest.raises(ValueError, match=r"other: shape \(3, 5, 6\), but the reference has \(4, 5, 6\)"):
        interval(one, two[:3])


def test_what_images_share_does_not_widen_the_interval():
    """The difficulty of an image moves both models: only a paired interval leaves it out."""
    one, two = drawn_images(np.random.default_rng(4), 40, 0.7, 0.65)
    paired = np.subtract(*interval(one, two)[::-1])
    unpaired = np.subtract(*interval(one, two[np.random.default_rng(0).permutation(40)])[::-1])
    assert paired < 0.7 * unpaired


def test_about_95_of_100_intervals_hold_the_true_difference():
    rng = np.random.default_rng(5)
    whole = drawn_images(rng, 4000, 0.7, 0.67)
    truth = float(np.diff([mean_iou(matrices.sum(axis=0)) for matrices in whole])[0])
    held = 0
    for start in range(0, 4000, 40):
        low, high = interval(*(matrices[start : start + 40] for matrices in whole), rounds=400)
        held += low <= truth <= high
    assert 88 <= held <= 99


def test_a_conclusion_is_only_drawn_where_the_interval_allows_it():
    assert in_words(-0.2, (-0.5, 0.1)) == "no difference found above 0.50 points"
    assert in_words(0.0, (-0.001, 0.002)) == "no difference found above 0.01 points"
    assert in_words(0.2, (0.05, 0.4)) == "gains 0.05 to 0.40 points"
    assert in_words(-0.2, (-0.4, -0.05)) == "loses 0.05 to 0.40 points"
