"""Depth from stereo: hand-worked values and properties. Equality with the published code: test_depth_reference.py."""

from collections import deque

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from foggy_synscapes.camera import Camera
from foggy_synscapes.depth import disparity
from foggy_synscapes.depth.completion import Stereo, complete
from foggy_synscapes.depth.kernels import matching, planes, twister
from foggy_synscapes.depth.superpixels import seeds, slic


def stereo(rows: int, columns: int, baseline: float = 0.5, fx: float = 400.0) -> Stereo:
    return Stereo(Camera(fx, fx, columns / 2, rows / 2, columns, rows), baseline)


def test_zero_and_missing_disparity_are_infinitely_far() -> None:
    assert disparity.depth(np.array([[0, 1, 257, 65535]], np.uint16), 0.25, 1024.0).tolist() == [
        [np.inf, np.inf, 256.0, 256 * 256 / 65534]
    ]


def test_matches_round_halves_away_from_zero() -> None:
    """Column 1 with d = 0.5 matches at 0.5, which is column 1; halves to even would give column 0, outside."""
    image = np.full((1, 4, 3), 100, np.uint8)
    assert not disparity.inconsistent(image, image, np.array([[129, 1, 1, 1]], np.uint16)).any()


def test_a_match_beyond_the_left_edge_is_an_outlier() -> None:
    image = np.full((1, 4, 3), 100, np.uint8)
    marked = disparity.inconsistent(image, image, np.array([[257, 257, 513, 513]], np.uint16))
    assert marked.tolist() == [[True, False, False, False]]


@pytest.mark.parametrize(("change", "outlier"), [((11, 0, 0), False), ((0, 13, 0), True), ((8, 8, 8), True)])
def test_colours_may_differ_by_12_levels_in_all(change: tuple[int, int, int], outlier: bool) -> None:
    left = np.full((1, 2, 3), 100, np.uint8)
    marked = disparity.inconsistent(left, left + np.array(change, np.uint8), np.ones((1, 2), np.uint16))
    assert marked.tolist() == [[outlier, outlier]]


def samples(seed: int, counts: list[int]) -> list[list[int]]:
    words, high = np.empty((2, twister.WORDS), np.uint32), np.empty(twister.DRAWS, np.uint32)
    words[0] = twister.seeded(np.uint32(seed))
    at, found, result = twister.DRAWS, np.zeros(3, np.int64), []
    for count in counts:
        at = twister.sample(words, high, at, count, found)
        result.append(found.tolist())
    return result


def test_the_first_permutation_is_the_documented_one() -> None:
    """MATLAB's documentation: randperm(8) after the default seed is 6 3 7 8 5 1 2 4."""
    assert samples(5489, [8]) == [[5, 2, 6]]


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1), st.lists(st.integers(3, 700), min_size=1, max_size=8))
def test_samples_are_the_first_three_of_numpys_permutations(seed: int, counts: list[int]) -> None:
    """The same stream in NumPy; counts beyond 312 draws take several blocks of it."""
    stream = np.random.RandomState(seed)
    assert samples(seed, counts) == [np.argsort(stream.random_sample(count))[:3].tolist() for count in counts]


def test_seeds_fill_the_side() -> None:
    assert seeds(1024, 32).tolist() == list(range(16, 1024, 32))
    assert seeds(190, 30).tolist() == [15, 46, 78, 110, 141, 173]  # 6 strips, 10 pixels left over: 1.67 each
    assert seeds(2, 5).tolist() == [1]


def test_segments_are_numbered_without_gaps_and_each_is_whole_before_small_parts_join() -> None:
    rng = np.random.default_rng(7)
    image = rng.integers(0, 256, (8, 12, 3), np.uint8).repeat(8, axis=0).repeat(8, axis=1)
    labels, count = slic(image, wanted=24)
    assert np.unique(labels).tolist() == list(range(count))
    assert np.bincount(labels.reshape(-1)).min() > 64 * 96 // 24 // 4  # smaller parts have joined a neighbour
    first = [int(np.argmax(labels.reshape(-1) == k)) for k in range(count)]
    assert first[0] == 0
    for k in range(count):  # whole: all of a segment can be reached from its first pixel
        assert reached(labels, divmod(first[k], labels.shape[1])) == np.count_nonzero(labels == k)


def reached(labels: np.ndarray, start: tuple[int, int]) -> int:
    seen, waiting = {start}, deque([start])
    while waiting:
        row, column = waiting.popleft()
        for y, x in ((row + 1, column), (row - 1, column), (row, column + 1), (row, column - 1)):
            inside = 0 <= y < labels.shape[0] and 0 <= x < labels.shape[1]
            if inside and (y, x) not in seen and labels[y, x] == labels[start]:
                seen.add((y, x))
                waiting.append((y, x))
    return len(seen)


def test_superpixels_follow_an_edge_in_colour() -> None:
    image = np.zeros((64, 64, 3), np.uint8)
    image[:, 27:] = 255  # not where a step between centres ends
    labels, _ = slic(image, wanted=16)
    assert not set(labels[:, :27].reshape(-1)) & set(labels[:, 27:].reshape(-1))


def test_too_small_an_image_for_so_many_superpixels_is_refused() -> None:
    with pytest.raises(ValueError, match="10 x 10 pixels, expected four or more for each of 26"):
        slic(np.zeros((10, 10, 3), np.uint8), wanted=26)


def one_segment(depth: np.ndarray, unreliable: np.ndarray) -> tuple[np.ndarray, np.ndarray, int, int]:
    """Depth, plane, state and draws of an image that is one segment."""
    labels, filled = np.zeros(depth.shape, np.int32), depth.copy()
    plane, states = np.zeros((1, 3)), np.zeros(1, np.uint8)
    counts = np.zeros((2, 1), np.int32)
    pixels = planes.pixels_of_segments(labels, 1)
    draws = planes.fit_segments(filled, unreliable, *pixels, np.uint32(5489), plane, states, *counts)
    return filled, plane[0], states[0], draws


def slope(rows: int = 6, columns: int = 8) -> np.ndarray:
    """Depth of the plane 0.5 x - 0.25 y + 20, x and y from 1."""
    y, x = np.mgrid[1 : rows + 1, 1 : columns + 1]
    return 0.5 * x - 0.25 * y + 20


def test_a_plane_fills_what_is_unreliable() -> None:
    depth, unreliable = slope(), np.zeros((6, 8), bool)
    unreliable[2:4, 3:6] = True
    broken = np.where(unreliable, 3.0, depth)
    filled, plane, state, _ = one_segment(broken, unreliable)
    assert state == planes.FITTED
    np.testing.assert_allclose(plane, [0.5, -0.25, 20], rtol=1e-12)
    np.testing.assert_allclose(filled, depth, rtol=1e-12)


def test_pixels_are_sorted_column_after_column() -> None:
    labels = np.array([[0, 1, 0], [0, 0, 1]], np.int32)
    begin, rows, columns = planes.pixels_of_segments(labels, 2)
    assert begin.tolist() == [0, 4, 6]
    assert list(zip(rows.tolist(), columns.tolist(), strict=True)) == [(0, 0), (1, 0), (1, 1), (0, 2), (0, 1), (1, 2)]


@pytest.mark.parametrize(("error", "kept"), [(49.0, True), (51.0, False), (np.inf, False)])
def test_known_depth_stays_unless_it_is_50_metres_off(error: float, kept: bool) -> None:
    depth = slope()
    depth[1, 1] += error
    filled = one_segment(depth, np.zeros(depth.shape, bool))[0]
    assert filled[1, 1] == (depth[1, 1] if kept else pytest.approx(slope()[1, 1]))


def test_depth_is_never_below_zero() -> None:
    _, x = np.mgrid[1:7, 1:9]
    depth, unreliable = 6.5 - 1.0 * x, np.zeros((6, 8), bool)
    unreliable[:, 6:] = True
    filled = one_segment(depth, unreliable)[0]
    assert (filled[:, 6:] == 0).all()
    assert (filled[:, :6] == depth[:, :6]).all()


def test_mostly_infinite_depth_is_a_far_segment_without_a_draw() -> None:
    depth = slope()
    depth[:4] = np.inf
    filled, plane, state, draws = one_segment(depth, np.zeros(depth.shape, bool))
    assert state == planes.INFINITE
    assert draws == 0
    assert np.isinf(plane).all()
    assert np.isinf(filled).all()


def test_more_infinite_depths_than_inliers_make_it_far_after_the_draws() -> None:
    depth = np.random.default_rng(1).uniform(10, 500, (6, 8))
    depth[:2] = np.inf
    filled, _, state, draws = one_segment(depth, np.zeros(depth.shape, bool))
    assert state == planes.INFINITE
    assert draws >= 32
    assert np.isinf(filled).all()


@pytest.mark.parametrize(("known", "seen"), [(19, False), (20, True)])
def test_a_plane_needs_20_known_pixels(known: int, seen: bool) -> None:
    depth, unreliable = slope(4, 6), np.ones(24, bool)
    unreliable[:known] = False
    assert (one_segment(depth, unreliable.reshape(4, 6))[2] != planes.UNSEEN) == seen


@pytest.mark.parametrize(("known", "seen"), [(59, False), (60, True)])
def test_a_plane_needs_60_percent_of_the_pixels(known: int, seen: bool) -> None:
    depth, unreliable = slope(10, 10), np.ones(100, bool)
    unreliable[:known] = False
    assert (one_segment(depth, unreliable.reshape(10, 10))[2] != planes.UNSEEN) == seen


def test_known_pixels_on_one_line_make_no_plane() -> None:
    """The published code would look for three other points for ever."""
    assert one_segment(np.full((1, 40), 20.0), np.zeros((1, 40), bool))[2] == planes.UNSEEN


def match(colours: list[float], columns: list[float], seen: list[bool]) -> tuple[list[int], list[int]]:
    lab, centroids = np.zeros((len(seen), 3)), np.zeros((len(seen), 2))
    lab[:, 0], centroids[:, 0] = colours, columns
    partners = np.empty(len(seen), np.int32)
    order = matching.match(lab, centroids, np.array(seen), 1.0, partners)
    return partners.tolist(), order.tolist()


def test_planes_are_handed_on_from_neighbour_to_neighbour() -> None:
    """Segment 3 is most like 2, which is most like 1; only 0 has depth."""
    assert match([0, 10, 20, 30], [0, 0, 0, 0], [True, False, False, False]) == ([-1, 0, 1, 2], [1, 2, 3])


def test_the_surest_match_comes_first() -> None:
    assert match([0, 5, 50, 51], [0, 0, 0, 0], [True, False, False, True]) == ([-1, 0, 3, -1], [2, 1])


def test_of_equal_matches_the_segment_with_depth_of_its_own_wins() -> None:
    """1 is as near to 0, which has depth, as to 2, which got it first."""
    assert match([0, 4, 8, 8], [0, 0, 0, 1], [True, False, False, True]) == ([-1, 0, 3, -1], [2, 1])


def test_place_counts_beside_colour() -> None:
    assert match([0, 0, 3], [0, 10, 12], [True, False, True])[0] == [-1, 2, -1]


def street(rows: int = 64, columns: int = 96) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A textured wall 20 m away, seen by both cameras with a disparity of 10 pixels."""
    texture = np.random.default_rng(3).integers(60, 200, (rows, columns + 10, 3), np.uint8)
    left, right = texture[:, :columns].copy(), texture[:, 10:].copy()
    return left, right, np.full((rows, columns), 10 * 256 + 1, np.uint16)


def test_a_wall_is_completed_where_the_other_camera_cannot_see_it() -> None:
    left, right, stored = street()
    stored[20:30, 40:50] = 0
    done = complete(left, right, stored, stereo(64, 96), wanted=24)
    assert done.missing.sum() == 100
    assert done.inconsistent[:, :10].all()  # beyond the right view's left edge
    np.testing.assert_allclose(done.depth, 20.0, rtol=1e-9)


def test_reliable_depth_is_left_as_it_is() -> None:
    left, right, stored = street()
    done = complete(left, right, stored, stereo(64, 96), wanted=24)
    known = ~(done.missing | done.inconsistent)
    np.testing.assert_array_equal(done.depth[known], disparity.depth(stored, 0.5, 400.0)[known])


def noisy() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A grey wall, where every match looks right, whose disparity errs by up to a pixel."""
    grey = np.full((64, 96, 3), 120, np.uint8)
    return grey, grey, np.random.default_rng(5).integers(10 * 256, 11 * 256, (64, 96), np.uint16)


def test_equal_seeds_give_equal_depth_and_others_do_not() -> None:
    left, right, stored = noisy()
    first, again, other = (complete(left, right, stored, stereo(64, 96), seed, 24) for seed in (5489, 5489, 1))
    np.testing.assert_array_equal(first.depth, again.depth)
    assert first.segments.draws == again.segments.draws
    assert not np.array_equal(first.segments.planes, other.segments.planes)


def test_the_order_of_images_changes_nothing() -> None:
    """The stream begins anew with each image."""
    one, two = noisy(), street()
    alone = complete(*two, stereo(64, 96), wanted=24).depth
    complete(*one, stereo(64, 96), wanted=24)
    np.testing.assert_array_equal(complete(*two, stereo(64, 96), wanted=24).depth, alone)


def test_disparity_that_is_nowhere_reliable_is_refused() -> None:
    left, right, stored = street()
    with pytest.raises(ValueError, match=r"none of .* superpixels has 20 pixels.*100\.0% of the pixels have none"):
        complete(left, right, stored * 0, stereo(64, 96), wanted=24)
    with pytest.raises(ValueError, match="look otherwise in the right image"):
        complete(left, 255 - right, stored, stereo(64, 96), wanted=24)


def test_arrays_that_do_not_belong_together_are_refused() -> None:
    left, right, stored = street()
    with pytest.raises(ValueError, match="shapes differ"):
        complete(left, right[:-1], stored, stereo(64, 96))
    with pytest.raises(ValueError, match="shapes differ"):
        complete(left, right, stored, stereo(64, 95))
    with pytest.raises(ValueError, match="expected uint16"):
        complete(left, right, stored.astype(np.uint8), stereo(64, 96))
    with pytest.raises(ValueError, match="left: float64"):
        complete(left / 255, right, stored, stereo(64, 96))
    with pytest.raises(ValueError, match="seed: -1"):
        complete(left, right, stored, stereo(64, 96), seed=-1)
    with pytest.raises(ValueError, match="baseline is 0"):
        stereo(64, 96, baseline=0)
