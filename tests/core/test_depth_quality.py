"""A simulated stereo camera, and how far completed depth and its fog are from the truth."""

import numpy as np
import pytest
import stereo_frames

from foggy_synscapes.camera import Camera
from foggy_synscapes.depth import quality
from foggy_synscapes.depth.disparity import depth as to_depth
from foggy_synscapes.depth.disparity import inconsistent
from foggy_synscapes.depth.filling import fill
from foggy_synscapes.depth.simulation import Errors, completed, measure
from foggy_synscapes.tables.depth_quality import collect, markdown

SIZE = ROWS, COLUMNS = 60, 100
CAMERA = Camera(110.0, 110.0, 50.5, 30.5, COLUMNS, ROWS)
EXACT = Errors(baseline=0.5, noise=0.0, step=1 / 256, least=0.0, levels=0.0)


def scene() -> tuple[np.ndarray, np.ndarray]:
    """A wall at 40 m, and a box at 8 m before it; sky above."""
    rng = np.random.default_rng(4)
    image = rng.integers(40, 200, (ROWS // 5, COLUMNS // 5, 3)).repeat(5, 0).repeat(5, 1).astype(np.uint8)
    depth = np.full(SIZE, 40.0)
    depth[:10], image[:10] = np.inf, 250
    depth[25:50, 40:70] = 8.0
    return image, depth


def measured(errors: Errors) -> tuple[np.ndarray, np.ndarray]:
    return measure(*scene(), CAMERA, errors, np.random.default_rng(1))


def test_holes_are_where_the_other_view_sees_nothing() -> None:
    _, stored = measured(EXACT)
    missing = stored == 0
    shift = round(110 * 0.5 / 8 - 110 * 0.5 / 40)  # the box hides so much of the wall on its left
    assert missing[30, 40 - shift + 2 : 40].all()
    assert not missing[30, 40:70].any()
    assert not missing[30, 71:].any()
    assert missing[30, 0]  # beyond the right view's edge
    found = to_depth(stored, 0.5, 110.0)
    _, depth = scene()
    np.testing.assert_allclose(found[~missing], depth[~missing], rtol=2e-3)


def test_the_right_view_shows_what_the_disparity_says() -> None:
    image, _ = scene()
    right, stored = measured(EXACT)
    assert inconsistent(image, right, stored)[stored > 0].mean() < 0.01


def test_sky_is_a_hole_where_small_disparities_are_not_found() -> None:
    assert (measured(EXACT)[1][:10] == 1).all()
    assert (measured(Errors(0.5, 0.0, 1 / 256, 0.5, 0.0))[1][:10] == 0).all()


@pytest.mark.parametrize("noise", [2.0, 8.0])
def test_noise_and_steps_are_as_large_as_stated_at_2048_columns(noise: float) -> None:
    exact, noisy = measured(EXACT)[1], measured(Errors(0.5, noise, 1 / 256, 0.0, 0.0))[1]
    both = (exact > 0) & (noisy > 0) & (exact > 257)
    apart = (noisy.astype(float) - exact)[both] / 256
    assert apart.std() == pytest.approx(noise * COLUMNS / 2048, rel=0.1)
    stepped = measured(Errors(0.5, 0.0, 20.48, 0.0, 0.0))[1].astype(int)  # one pixel here
    assert set(((stepped - 1) % 256)[stepped > 0]) == {0}


def test_completed_depth_of_exact_disparity_is_nearly_true() -> None:
    image, depth = scene()
    found = completed(image, depth, CAMERA, EXACT, (1, 2), 48)
    np.testing.assert_array_equal(found, completed(image, depth, CAMERA, EXACT, (1, 2), 48))
    near = np.isfinite(depth)
    assert np.median(np.abs(found[near] - depth[near]) / depth[near]) < 0.01


def test_errors_are_counted_by_class_and_distance_and_add_up() -> None:
    labels = np.array([[0, 0, 10, 255]], np.uint8)
    depth, other = np.array([[10.0, 30.0, np.inf, 150.0]]), np.array([[11.0, 30.0, 500.0, 150.0]])
    t = np.array([[0.9, 0.7, 0.0, 0.2]])
    image = np.zeros((1, 4, 3), np.uint8)
    foggy = image.copy()
    foggy[0, 2] = 30, 60, 90
    found = quality.sums(labels, (depth, other), (t, t + 0.1), (image, foggy))
    assert found[..., 0].sum() == 4
    np.testing.assert_allclose(found[0, 0], [1, 1, 0.1, 0.1, 0])
    np.testing.assert_allclose(found[10, 4], [1, 500, 0.5, 0.1, 60])  # sky counts as 1 km
    assert found[19, 3, 0] == 1
    names = ("class", "distance", *quality.SUMS)
    cells = ("road", "0 to 25 m", 3, 6, 0.3, 0.6, 9), ("sky", "beyond 200 m", 1, 500, 0.5, 0, 1)
    lines = collect("0.01", [dict(zip(names, map(str, row), strict=True)) for row in cells])
    assert [line[1:4] for line in lines] == [
        ("all", "all", 4), ("distance", "0 to 25 m", 3), ("distance", "beyond 200 m", 1), ("class", "road", 3),
        ("class", "sky", 1),
    ]  # fmt: skip
    assert "| road | 75.0 % | 2.0 | 10.0 | 0.200 | 3.0 |" in markdown(lines, stand_in=True)


def test_few_measured_pixels_are_completed_and_stay_as_they_are() -> None:
    arrays = stereo_frames.content(0)
    y, x = np.mgrid[: stereo_frames.SIZE[0], : stereo_frames.SIZE[1]]
    truth = np.where(y < 110, 25 + 0.05 * x, 1.3 * 350 / np.maximum(y - 90, 1))
    sparse = np.where(np.random.default_rng(0).random(truth.shape) < 0.05, truth, np.nan)
    found = fill(arrays["left"], sparse)
    known = np.isfinite(sparse)
    np.testing.assert_array_equal(found[known], truth[known])
    assert np.median(np.abs(found - truth) / truth) < 0.02
