"""Fog: hand-worked values, the plain formula as oracle, properties, and the answer at every extreme."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from foggy_synscapes.camera import Camera
from foggy_synscapes.fog.frame import foggy_frame
from foggy_synscapes.fog.geometry import Rays, rays, straight
from foggy_synscapes.fog.optics import (
    attenuation,
    count_zero_depth,
    foggy_images,
    foggy_scan_lines,
    meteorological_optical_range,
    transmittance,
    transmittance_images,
)

PAPER_BETAS = (0.005, 0.01, 0.02, 0.03, 0.06)
CAMERA = Camera(fx=20.0, fy=21.0, u0=8.3, v0=5.1, resx=16, resy=11)
RNG = np.random.default_rng(5)


def oracle(image: np.ndarray, depth: np.ndarray, lines: Rays, airlight, beta: float) -> np.ndarray:
    """The published formula in plain float64 NumPy."""
    with np.errstate(over="ignore"):
        t = np.exp(-beta * (depth.astype(np.float64) * lines.factor()))[..., None]
    radiance = t * (image / 255.0) + (1 - t) * (np.array(airlight) / 255.0)
    return np.clip(np.floor(255 * radiance + 0.5), 0, 255).astype(np.uint8)


def oracle_transmittance(depth: np.ndarray, lines: Rays, beta: float) -> np.ndarray:
    return np.floor(255 * np.exp(-beta * (depth.astype(np.float64) * lines.factor())) + 0.5).astype(np.uint8)


@st.composite
def frames(draw):
    """Image, depth, rays and airlight of a small frame, with far and near distances."""
    height, width = draw(st.integers(1, 9)), draw(st.integers(1, 70))
    image = draw(arrays.arrays(np.uint8, (height, width, 3)))
    metres = st.floats(0, 1e5, width=32) | st.sampled_from([0.0, math.inf, 8935.0])
    depth = draw(arrays.arrays(np.float32, (height, width), elements=metres))
    camera = Camera(fx=30.0, fy=31.0, u0=draw(st.floats(-9, 80)), v0=3.0, resx=width, resy=height)
    airlight = draw(st.tuples(*[st.integers(0, 255)] * 3))
    return image, depth, rays(camera, draw(st.sampled_from(["paper", "exact"]))), airlight


positive_betas = st.floats(1e-6, 10)


def test_visibility_of_the_papers_betas() -> None:
    """Section III: about 600, 300, 150, 100 and 50 m."""
    assert [round(meteorological_optical_range(beta)) for beta in PAPER_BETAS] == [599, 300, 150, 100, 50]
    for beta in PAPER_BETAS:
        assert attenuation(meteorological_optical_range(beta)) == pytest.approx(beta, rel=1e-15)
    for value in (0, -1, math.nan, math.inf):
        with pytest.raises(ValueError, match="expected a finite number above 0"):
            meteorological_optical_range(value)


def test_half_the_light_comes_through_at_the_half_value_distance() -> None:
    """By hand: t = 1/2, so F = 100/2 + 220/2 = 160; at twice the distance t = 1/4: 25 + 165 = 190."""
    image, depth = np.full((1, 2, 3), 100, np.uint8), np.array([[64.0, 128.0]], np.float32)
    foggy = foggy_images(image, depth, straight((1, 2)), (220, 220, 220), [math.log(2) / 64])
    assert foggy[0, 0].tolist() == [[160] * 3, [190] * 3]


def test_a_half_is_rounded_up() -> None:
    """t = 1/2 of 255 is 127.5: 128, by floor(255 x + 0.5)."""
    levels = transmittance_images(np.array([[64.0]], np.float32), straight((1, 1)), [math.log(2) / 64])
    assert levels.tolist() == [[[128]]]


@settings(max_examples=150, deadline=None)
@given(frames(), st.lists(positive_betas | st.sampled_from(PAPER_BETAS), min_size=1, max_size=5))
def test_all_betas_in_one_pass_are_the_plain_formula_at_each(frame, betas) -> None:
    image, depth, lines, airlight = frame
    betas = [*betas, *(times * betas[0] for times in (2, 4, 8))]  # of these, transmittances are squares
    foggy = foggy_images(image, depth, lines, airlight, betas)
    levels = transmittance_images(depth, lines, betas)
    for beta, one, t in zip(betas, foggy, levels, strict=True):
        np.testing.assert_array_equal(one, oracle(image, depth, lines, airlight, beta))
        np.testing.assert_array_equal(t, oracle_transmittance(depth, lines, beta))


@pytest.mark.parametrize("width", [1, 15, 63, 64, 65, 129, 400])
def test_the_levels_are_those_of_float64_whatever_the_width_of_vectors(width: int) -> None:
    """A million samples, of which hundreds lie so near a step that float32 could err."""
    height = 170_000 // width // 2
    image = RNG.integers(0, 256, (height, width, 3), dtype=np.uint8)
    depth = (RNG.random((height, width)) ** 3 * 700).astype(np.float32)
    lines = rays(Camera(300.0, 300.0, width / 2, 100.0, width, height))
    betas = PAPER_BETAS[::-1]
    for beta, foggy in zip(betas, foggy_images(image, depth, lines, (251, 255, 249), betas), strict=True):
        np.testing.assert_array_equal(foggy, oracle(image, depth, lines, (251, 255, 249), beta))


@settings(max_examples=60, deadline=None)
@given(frames(), positive_betas)
def test_fog_lies_between_the_clear_image_and_the_airlight(frame, beta) -> None:
    image, depth, lines, airlight = frame
    foggy = foggy_images(image, depth, lines, airlight, [beta])[0]
    light = np.array(airlight, np.uint8)
    assert (foggy >= np.minimum(image, light)).all()
    assert (foggy <= np.maximum(image, light)).all()


@settings(max_examples=60, deadline=None)
@given(frames(), positive_betas, positive_betas)
def test_more_fog_is_nearer_to_the_airlight(frame, one, other) -> None:
    image, depth, lines, airlight = frame
    foggy = foggy_images(image, depth, lines, airlight, sorted([one, other])).astype(int)
    distance = np.abs(foggy - np.array(airlight))
    assert (distance[1] <= distance[0]).all()
    t = transmittance_images(depth, lines, sorted([one, other]))
    assert (t[1] <= t[0]).all()


@settings(max_examples=40, deadline=None)
@given(frames())
def test_no_fog_is_the_identity(frame) -> None:
    image, depth, lines, airlight = frame
    np.testing.assert_array_equal(foggy_images(image, depth, lines, airlight, [0, 0.1])[0], image)
    assert (transmittance_images(depth, lines, [0])[0] == 255).all()


@settings(max_examples=60, deadline=None)
@given(frames(), positive_betas, st.data())
def test_cropping_and_fogging_commute(frame, beta, data) -> None:
    image, depth, lines, airlight = frame
    top, left = data.draw(st.integers(0, depth.shape[0] - 1)), data.draw(st.integers(0, depth.shape[1] - 1))
    height = data.draw(st.integers(1, depth.shape[0] - top))
    width = data.draw(st.integers(1, depth.shape[1] - left))
    window = np.s_[top : top + height, left : left + width]
    crop = foggy_images(image[window], depth[window], lines.crop(top, left, height, width), airlight, [beta])
    np.testing.assert_array_equal(crop[0], foggy_images(image, depth, lines, airlight, [beta])[0][window])


def test_transmittance_is_a_share() -> None:
    distance = np.array([0, 1e-300, 1.0, 1e3, 1e38, math.inf])
    for beta in (0, 1e-12, 0.005, 1e3):
        t = transmittance(distance, beta)
        assert (t >= 0).all()
        assert (t <= 1).all()
        assert (np.diff(t) <= 0).all()
        assert t[0] == 1


# The extremes: what the answer has to be.
ONE = np.full((1, 1, 3), 40, np.uint8)
LIGHT = (200, 210, 220)


def at(depth: float, beta: float) -> list[int]:
    return foggy_images(ONE, np.array([[depth]], np.float32), straight((1, 1)), LIGHT, [beta])[0, 0, 0].tolist()


@pytest.mark.parametrize("beta", [1e-300, 1e-44, 1e-12, 0.005, 1e3, 1e300])
def test_distance_zero_is_clear_and_infinity_is_airlight(beta: float) -> None:
    assert at(0.0, beta) == [40, 40, 40]
    assert at(math.inf, beta) == list(LIGHT)
    depth = np.array([[0.0, math.inf]], np.float32)
    for foggy in foggy_images(np.full((1, 2, 3), 40, np.uint8), depth, straight((1, 2)), LIGHT, [beta, 2 * beta]):
        assert foggy[0].tolist() == [[40, 40, 40], list(LIGHT)]


@pytest.mark.parametrize("beta", [1e-300, 1e-50, 1e-39, 1e-38, 2e-37, 5e36, 1e38, 1e40, 1e45, 1e300])
def test_betas_that_need_distances_at_the_ends_of_float32_are_the_plain_formula(beta: float) -> None:
    depth = np.array([[1e-45, 1e-40, 1.2e-38, 1e-37, 1e-20, 1.0, 1e20, 1e37, 3e38]], np.float32)
    lines = Rays(np.array([2.0]), np.arange(9.0), 1.0)  # factors from 1.4 to 3.2: distances overflow float32
    image = RNG.integers(0, 256, (1, 9, 3), dtype=np.uint8)
    for betas in ([beta], [beta, 2 * beta]):
        for one, foggy in zip(betas, foggy_images(image, depth, lines, LIGHT, betas), strict=True):
            np.testing.assert_array_equal(foggy, oracle(image, depth, lines, LIGHT, one))


def test_no_beta_gives_no_image() -> None:
    depth, lines = np.ones((11, 16), np.float32), rays(CAMERA)
    assert foggy_images(np.zeros((11, 16, 3), np.uint8), depth, lines, LIGHT, []).shape == (0, 11, 16, 3)
    assert transmittance_images(depth, lines, []).shape == (0, 11, 16)


def test_infinite_distance_without_fog_is_clear() -> None:
    assert at(math.inf, 0) == [40, 40, 40]


def test_thin_and_dense_fog() -> None:
    assert at(8935.0, 1e-12) == [40, 40, 40]
    assert at(5.39, 1e3) == list(LIGHT)
    assert at(3e38, 1e-12) == list(LIGHT)


def test_sky_is_exactly_airlight() -> None:
    """The far dome of Synscapes begins at 7.9 km: t is 7e-18 at the lightest fog of the paper."""
    image = RNG.integers(0, 256, (64, 64, 3), dtype=np.uint8)
    foggy = foggy_images(image, np.full((64, 64), 7900, np.float32), straight((64, 64)), LIGHT, PAPER_BETAS)
    assert (foggy == np.array(LIGHT, np.uint8)).all()


@pytest.mark.parametrize("airlight", [(0, 0, 0), (255, 255, 255)])
def test_what_fog_hides_is_the_formula_where_the_airlight_begins_and_behind(airlight) -> None:
    """Half a level of the whole range is left at an optical depth of ln 510 = 6.234: rows just before and behind."""
    depth = np.linspace(6.0, 6.5, 100 * 200, dtype=np.float32).reshape(100, 200)
    depth[::7, 64:128] = math.inf
    image = np.where(RNG.random((100, 200, 3)) < 0.5, 0, 255).astype(np.uint8)
    foggy = foggy_images(image, depth, straight((100, 200)), airlight, [1.0, 1.01])
    for beta, one in zip((1.0, 1.01), foggy, strict=True):
        np.testing.assert_array_equal(one, oracle(image, depth, straight((100, 200)), airlight, beta))
    levels = transmittance_images(depth, straight((100, 200)), [1.0])[0]
    np.testing.assert_array_equal(levels, oracle_transmittance(depth, straight((100, 200)), 1.0))
    assert {0, 1} == set(np.unique(levels))


@pytest.mark.parametrize("wrong", [-1.0, -math.inf, math.nan])
def test_negative_or_missing_distance_is_refused(wrong: float) -> None:
    depth = np.array([[1.0, wrong]], np.float32)
    image = np.zeros((1, 2, 3), np.uint8)
    for call in (
        lambda: foggy_images(image, depth, straight((1, 2)), LIGHT, [0.005]),
        lambda: transmittance_images(depth, straight((1, 2)), [0.005]),
        lambda: count_zero_depth(depth),
        lambda: transmittance(depth, 0.005),
    ):
        with pytest.raises(ValueError, match="negative or not a number"):
            call()


@pytest.mark.parametrize("beta", [-0.005, math.nan, math.inf])
def test_impossible_beta_is_refused(beta: float) -> None:
    depth = np.ones((1, 1), np.float32)
    for call in (
        lambda: foggy_images(ONE, depth, straight((1, 1)), LIGHT, [0.005, beta]),
        lambda: transmittance_images(depth, straight((1, 1)), [beta]),
        lambda: transmittance(depth, beta),
    ):
        with pytest.raises(ValueError, match=r"beta: .*, expected a finite number"):
            call()


@pytest.mark.parametrize("shape", [(1, 16), (11, 1), (16, 11), (10, 16)])
def test_depth_of_another_size_is_refused_and_never_broadcast(shape: tuple[int, int]) -> None:
    image = np.zeros((11, 16, 3), np.uint8)
    with pytest.raises(ValueError, match="shapes differ"):
        foggy_images(image, np.ones(shape, np.float32), rays(CAMERA), LIGHT, [0.005])
    with pytest.raises(ValueError, match="shapes differ"):
        foggy_images(image, np.ones((11, 16), np.float32), straight(shape), LIGHT, [0.005])


def test_other_arrays_are_refused() -> None:
    depth, lines = np.ones((11, 16), np.float32), rays(CAMERA)
    image = np.zeros((11, 16, 3), np.uint8)
    with pytest.raises(ValueError, match="image: float64"):
        foggy_images(image / 255, depth, lines, LIGHT, [0.005])
    with pytest.raises(ValueError, match="image: uint8"):
        foggy_images(image[..., :2], depth, lines, LIGHT, [0.005])
    with pytest.raises(ValueError, match="image: uint8"):
        foggy_images(image[:, :0], depth[:, :0], lines, LIGHT, [0.005])
    with pytest.raises(ValueError, match="depth: float16"):
        foggy_images(image, depth.astype(np.float16), lines, LIGHT, [0.005])
    with pytest.raises(ValueError, match="airlight: "):
        foggy_images(image, depth, lines, (1, 2), [0.005])


@pytest.mark.parametrize("shape", [(2, 49), (1, 48), (1, 97)])
def test_scan_lines_need_room(shape: tuple[int, int]) -> None:
    image, depth = np.zeros((4, 16, 3), np.uint8), np.ones((4, 16), np.float32)
    draw = foggy_scan_lines(image, depth, straight((4, 16)), LIGHT, [0.005])
    with pytest.raises(ValueError, match="out: "):
        draw(slice(0, 4, 2), np.zeros(shape, np.uint8))


@pytest.mark.parametrize("wanted", [slice(0, 1), slice(3, 7), slice(0, 11), slice(8, 20), slice(0, 11, 4)])
@pytest.mark.parametrize("width", [1, 2, 16, 32, 33, 34, 48, 49, 64, 65, 130])
def test_scan_lines_are_the_differences_of_the_same_images(width: int, wanted: slice) -> None:
    """Of every width below and above a vector, and from any place in memory on: lines have odd lengths."""
    image = RNG.integers(0, 256, (11, width, 3), dtype=np.uint8)
    depth, line = RNG.random((11, width), dtype=np.float32) * 300, 1 + 3 * width
    out = np.full((3, 11 * line + 5), 77, np.uint8)
    camera, betas = dataclasses.replace(CAMERA, resx=width), (0, 0.06, 0.005)
    foggy_scan_lines(image, depth, rays(camera), LIGHT, betas)(wanted, out)
    images = foggy_images(image, depth, rays(camera), LIGHT, betas)[:, wanted]
    written = images.shape[1] * line
    lines = out[:, :written].reshape(3, -1, line)
    assert (lines[:, :, 0] == 1).all()  # the filter's number
    pixels = np.cumsum(lines[:, :, 1:].reshape(images.shape), axis=2, dtype=np.uint8)
    np.testing.assert_array_equal(pixels, images)
    assert (out[:, written:] == 77).all()


def test_views_give_the_same_fog() -> None:
    image = RNG.integers(0, 256, (11, 32, 3), dtype=np.uint8)
    depth = RNG.random((11, 32), dtype=np.float32) * 300
    lines = rays(CAMERA)
    plain = foggy_images(image[:, ::2].copy(), depth[:, ::2].copy(), lines, LIGHT, [0.01])
    np.testing.assert_array_equal(foggy_images(image[:, ::2], depth[:, ::2], lines, LIGHT, [0.01]), plain)


def test_pixels_at_distance_zero_are_counted() -> None:
    assert count_zero_depth(np.array([[0.0, 1.0, 0.0]], np.float32)) == 2


def test_a_frame_is_fogged_with_its_own_airlight() -> None:
    image = RNG.integers(0, 256, (11, 16, 3), dtype=np.uint8)
    foggy = foggy_frame(image, np.full((11, 16), np.inf, np.float32), CAMERA, [0.005, 0.06], "exact")
    assert len(foggy) == 2
    assert len(np.unique(foggy[0].reshape(-1, 3), axis=0)) == 1
