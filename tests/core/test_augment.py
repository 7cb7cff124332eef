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


def rare(size=(60, 80)):
    """A map of one class, with a square of a second class that one place in a hundred has, and a pixel unlabelled."""
    labels = np.zeros(size, np.uint8)
    labels[50:56, 70:78] = 18
    labels[0, 0] = 255
    return np.repeat(labels[..., None], 3, axis=2), labels


@pytest.mark.parametrize(("balanced", "least", "most"), [(False, 0, 40), (True, 80, 130)])
def test_balanced_crops_hold_a_rare_class_half_of_the_time(balanced, least, most):
    image, labels = rare()
    held = 0
    for step in range(200):
        random = generator(0, "augment", step, 0)
        cut, cut_labels = augment(image, labels, (10, 10), (1.0, 1.0), True, random, balanced)
        assert np.array_equal(cut[..., 0], cut_labels)
        held += bool((cut_labels == 18).any())
    assert least <= held <= most


def test_balanced_crops_have_the_drawn_pixel_in_their_middle_where_the_image_allows_it():
    labels = np.full((40, 60), 255, np.uint8)
    labels[20, 31] = 5
    labels[0, 59] = 5
    found = set()
    for step in range(40):
        random = generator(0, "augment", step, 0)
        _, cut = augment(np.zeros((40, 60, 3), np.uint8), labels, (10, 10), (1.0, 1.0), False, random, True)
        found |= {tuple(place) for place in np.argwhere(cut == 5).tolist()}
    assert found == {(5, 5), (0, 9)}


def test_balance_leaves_a_map_without_labels_as_it_would_be():
    image, _ = coded()
    labels = np.full(image.shape[:2], 255, np.uint8)
    found = []
    for balanced in (False, True):
        random = generator(0, "augment", 1, 0)
        found.append(augment(image, labels, (16, 16), (0.7, 1.3), True, random, balanced)[0])
    assert np.array_equal(*found)
