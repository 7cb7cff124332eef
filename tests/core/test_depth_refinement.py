"""Refinement of transmittance against plain implementations, and its properties."""

from itertools import product

import numpy as np
import pytest

from foggy_synscapes.depth import annotation, refinement
from foggy_synscapes.depth.colour import lab


def picture(rows: int = 30, columns: int = 50, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    smooth = rng.integers(0, 256, (rows // 10 + 1, columns // 10 + 1, 3)).repeat(10, axis=0).repeat(10, axis=1)
    return np.clip(smooth[:rows, :columns] + rng.integers(-9, 10, (rows, columns, 3)), 0, 255).astype(np.uint8)


def window_means(values: np.ndarray, radius: int) -> np.ndarray:
    padded = np.pad(values, radius, mode="edge")
    return np.lib.stride_tricks.sliding_window_view(padded, (2 * radius + 1, 2 * radius + 1)).mean(axis=(2, 3))


def plain_guided(image: np.ndarray, source: np.ndarray, radius: int, epsilon: float) -> np.ndarray:
    """The formulas of He, Sun and Tang, with a linear system solved at each pixel."""
    guide = image / 255
    mean = np.stack([window_means(guide[..., c], radius) for c in range(3)], axis=-1)
    cov = np.empty((*source.shape, 3, 3))
    for c, d in product(range(3), repeat=2):
        cov[..., c, d] = window_means(guide[..., c] * guide[..., d], radius) - mean[..., c] * mean[..., d]
    average = window_means(source, radius)
    with_source = np.stack([window_means(guide[..., c] * source, radius) for c in range(3)], axis=-1)
    right = with_source - mean * average[..., None]
    slopes = np.linalg.solve(cov + epsilon * np.eye(3), right[..., None])[..., 0]
    offset = average - (slopes * mean).sum(axis=-1)
    around = np.stack([window_means(slopes[..., c], radius) for c in range(3)], axis=-1)
    return (around * guide).sum(axis=-1) + window_means(offset, radius)


def test_the_guided_filter_is_the_formula_at_every_pixel() -> None:
    image, source = picture(), np.random.default_rng(1).random((30, 50))
    expected = np.clip(plain_guided(image, source, refinement.RADIUS, refinement.EPSILON), 0, 1)
    np.testing.assert_allclose(refinement.guided(image)(source), expected, atol=1e-12)


def test_images_smaller_than_the_window_are_filtered_too() -> None:
    image, source = picture(3, 5), np.random.default_rng(1).random((3, 5))
    expected = np.clip(plain_guided(image, source, refinement.RADIUS, refinement.EPSILON), 0, 1)
    np.testing.assert_allclose(refinement.guided(image)(source), expected, atol=1e-12)


def test_the_guided_filter_gives_no_more_than_1_and_no_less_than_0() -> None:
    image = picture(seed=4)
    source = (image[..., 0] > 128).astype(float)
    refined = refinement.guided(image)(source)
    assert refined.min() >= 0
    assert refined.max() <= 1
    assert plain_guided(image, source, refinement.RADIUS, refinement.EPSILON).max() > 1  # so that this says something


def rounded(values: np.ndarray) -> np.ndarray:
    return np.floor(values + 0.5).astype(int)


def three(values: np.ndarray, axis: int) -> np.ndarray:
    """Convolution with a Gaussian of one cell, cut off after one, along an axis; zero outside."""
    side, middle = np.array([np.exp(-0.5), 1.0]) / (1 + 2 * np.exp(-0.5))
    moved = np.moveaxis(np.pad(values, [(1, 1) if a == axis else (0, 0) for a in range(values.ndim)]), axis, 0)
    return np.moveaxis(side * moved[:-2] + middle * moved[1:-1] + side * moved[2:], 0, axis)


def plain_bilateral(image: np.ndarray, labels: np.ndarray, source: np.ndarray) -> np.ndarray:
    """Both grids whole, and corner by corner."""
    colour = lab(image) / 100
    colour[..., 1:] -= colour[..., 1:].min(axis=(0, 1))
    rows, columns = np.mgrid[: source.shape[0], : source.shape[1]] / 20
    low = colour.min(axis=(0, 1))
    where = [rows, columns, *np.moveaxis((colour - low) / 0.1, -1, 0)]
    shape = [int(np.floor(axis.max())) + 7 for axis in where]
    total = []
    for axes, label, share in ((where, None, 5.0), (where[:2], labels, 1.0)):
        found = []
        for weights in (source, np.ones_like(source)):
            extra = [] if label is None else [labels.max() + 1]
            grid = np.zeros(shape[: len(axes)] + extra)
            index = [rounded(axis) + 3 for axis in axes] + ([] if label is None else [label])
            np.add.at(grid, tuple(index), weights)
            for axis in range(len(axes)):
                grid = three(grid, axis)
            read = np.zeros_like(source)
            for corner in product((0, 1), repeat=len(axes)):
                places, part = [], np.ones_like(source)
                for axis, step in zip(axes, corner, strict=True):
                    fraction = axis - np.floor(axis)
                    part = part * (fraction if step else 1 - fraction)
                    places.append(np.floor(axis).astype(int) + 3 + step)
                read += part * grid[tuple(places + ([] if label is None else [label]))]
            found.append(share * read)
        total.append(found)
    return (total[0][0] + total[1][0]) / (total[0][1] + total[1][1])


@pytest.mark.parametrize("size", [(30, 50), (61, 41), (1, 2), (20, 21)])
def test_the_bilateral_filter_on_rows_of_cells_is_that_on_whole_grids(size: tuple[int, int]) -> None:
    rng = np.random.default_rng(2)
    image, source = picture(*size), rng.random(size)
    labels = np.arange(size[0] * size[1]).reshape(size).astype(np.int32) * 4 // (size[0] * size[1])
    np.testing.assert_allclose(
        refinement.bilateral(image, labels)(source), plain_bilateral(image, labels, source), atol=1e-13
    )


@pytest.mark.parametrize("value", [0.0, 0.37, 1.0])
def test_constant_transmittance_stays(value: float) -> None:
    image, labels = picture(), np.zeros((30, 50), np.int32)
    for refine in (refinement.guided(image), refinement.bilateral(image, labels)):
        np.testing.assert_allclose(refine(np.full((30, 50), value)), value, atol=1e-12)


def test_labels_keep_a_step_that_colour_does_not_show() -> None:
    image, source = np.full((40, 40, 3), 128, np.uint8), np.repeat([[0.2, 0.8]], 20, axis=1).repeat(40, axis=0)
    one = np.zeros((40, 40), np.int32)
    two = (source > 0.5).astype(np.int32)
    without, within = (np.diff(refinement.bilateral(image, labels)(source)[20])[19] for labels in (one, two))
    assert within > without + 0.05


def test_ids_become_labels_in_their_order_without_gaps() -> None:
    ids = np.array([[7, 26001, 26000], [3, 7, 3]], np.uint16)
    assert annotation.labels(ids).tolist() == [[0, 2, 1], [0, 0, 0]]  # out of roi at the end: of two at 1 pixel, the 7


def test_out_of_roi_takes_the_nearest_id_and_the_first_column_of_equally_near_ones() -> None:
    ids = np.full((5, 9), 3, np.uint16)
    ids[2, 0], ids[2, 8], ids[0, 4] = 10, 20, 30
    found = annotation.labels(ids)
    assert found[2].tolist() == [0, 0, 0, 2, 2, 2, 1, 1, 1]
    assert found[4].tolist() == [0, 0, 0, 0, 2, 1, 1, 1, 1]  # at (4, 4) 16 to the 30, 20 to both others


def test_out_of_roi_everywhere_is_refused() -> None:
    with pytest.raises(ValueError, match="all pixels are 3"):
        annotation.labels(np.full((2, 2), 3, np.uint16))
    with pytest.raises(ValueError, match="uint8"):
        annotation.labels(np.full((2, 2), 3, np.uint8))


def test_labels_of_another_size_are_refused() -> None:
    with pytest.raises(ValueError, match=r"labels: \(30, 49\)"):
        refinement.bilateral(picture(), np.zeros((30, 49), np.int32))


def test_no_light_comes_from_infinity_but_without_fog() -> None:
    from foggy_synscapes.fog.geometry import straight

    depth = np.array([[np.inf, 100.0, 0.0]])
    assert refinement.initial(depth, straight((1, 3)), np.log(2) / 100).tolist() == [[0.0, 0.5, 1.0]]
    assert refinement.initial(depth, straight((1, 3)), 0.0).tolist() == [[1.0, 1.0, 1.0]]


def test_composite_rounds_halves_up() -> None:
    image = np.array([[[0, 1, 255]]], np.uint8)
    assert refinement.composite(image, np.array([[0.5]]), (1, 2, 0)).tolist() == [[[1, 2, 128]]]
