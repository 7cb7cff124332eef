"""Augmentation moves image and labels together, and depends on nothing but its generator."""

import numpy as np
import pytest

from foggy_synscapes.training.augment import FILL, augment
from foggy_synscapes.training.streams import generator


def coded(height=40, width=56):
    """An image whose red and green channels are the pixel's place, and a label map that is its column."""
    rows, columns = np.mgrid[:height, :width].astype(np.uint8)
    return np.stack([rows, columns, np.full_like(rows, 7)], axis=-1), columns.copy()


def test_same_generator_same_result():
    image, labels = coded()
    first = augment(image, labels, (32, 32), (0.5, 2.0), True, generator(1, "augment", 5, 2))
    again = augment(image, labels, (32, 32), (0.5, 2.0), True, generator(1, "augment", 5, 2))
    other = augment(image, labels, (32, 32), (0.5, 2.0), True, generator(1, "augment", 5, 3))
    assert np.array_equal(first[0], again[0])
    assert np.array_equal(first[1], again[1])
    assert not np.array_equal(first[0], other[0])


def test_scale_1_is_a_plain_crop():
    image, labels = coded()
    cut, cut_labels = augment(image, labels, (16, 24), (1.0, 1.0), False, generator(0, "augment", 0, 0))
    top, left = cut[0, 0, 0], cut[0, 0, 1]
    assert np.array_equal(cut, image[top : top + 16, left : left + 24])
    assert np.array_equal(cut_labels, labels[top : top + 16, left : left + 24])


@pytest.mark.parametrize("step", range(12))
def test_labels_follow_the_image(step):
    image, labels = coded()
    cut, cut_labels = augment(image, labels, (20, 20), (0.7, 2.0), True, generator(0, "augment", step, 0))
    inside = cut_labels != 255
    assert inside.any()
    # Bilinear resizing blends neighbours, nearest takes one of them.
    difference = np.abs(cut[..., 1].astype(int) - cut_labels)[inside]
    assert np.median(difference) <= 1


def test_flip_happens_in_about_half_of_the_cases():
    image, labels = coded()
    flipped = 0
    for step in range(200):
        _, cut = augment(image, labels, (8, 8), (1.0, 1.0), True, generator(0, "augment", step, 0))
        flipped += cut[0, 0] > cut[0, -1]
    assert 70 < flipped < 130


def test_window_larger_than_the_image_is_filled_and_ignored():
    image, labels = coded(10, 12)
    cut, cut_labels = augment(image, labels, (32, 32), (1.0, 1.0), False, generator(0, "augment", 0, 0))
    assert cut.shape == (32, 32, 3)
    outside = cut_labels == 255
    assert outside.sum() == 32 * 32 - 10 * 12
    assert np.array_equal(np.unique(cut[outside].reshape(-1, 3), axis=0), [FILL])


def test_every_place_can_be_cropped():
    image, labels = coded(9, 9)
    places = {
        tuple(augment(image, labels, (8, 8), (1.0, 1.0), False, generator(0, "augment", step, 0))[0][0, 0, :2])
        for step in range(60)
    }
    assert places == {(0, 0), (0, 1), (1, 0), (1, 1)}


def test_sizes_that_differ_are_refused():
    image, labels = coded()
    with pytest.raises(ValueError, match="labels"):
        augment(image, labels[1:], (8, 8), (1.0, 1.0), False, generator(0, "augment", 0, 0))
