"""The airlight: a plain version of the published ranking as oracle, ties, tiny images, blue skies."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from foggy_synscapes.fog.airlight import GREY, Airlight, candidates, dark_channel, estimate

RNG = np.random.default_rng(3)


def oracle_dark(image: np.ndarray) -> np.ndarray:
    """Minimum over channels and 15 x 15 pixels; outside the image counts as +infinity."""
    padded = np.pad(image.min(axis=2).astype(float), 7, constant_values=np.inf)
    return np.lib.stride_tricks.sliding_window_view(padded, (15, 15)).min(axis=(2, 3))


def oracle_ranked(image: np.ndarray) -> np.ndarray:
    """As the published code: all pixels ranked column by column, a stable descending sort; their numbers there."""
    dark = oracle_dark(image).ravel(order="F")
    count = dark.size // 1000
    count += (count + 1) % 2
    return np.argsort(-dark, kind="stable")[:count]


def oracle(image: np.ndarray) -> Airlight:
    """As the published code: the first of the median grey value."""
    height = image.shape[0]
    ranked = oracle_ranked(image)
    count = ranked.size
    colours = image.transpose(1, 0, 2).reshape(-1, 3)
    grey = [sum(int(weight) * int(level) for weight, level in zip(GREY, colours[i], strict=True)) for i in ranked]
    chosen = ranked[grey.index(sorted(grey)[count // 2])]
    return Airlight(*(int(level) for level in colours[chosen]), int(chosen) % height, int(chosen) // height)


@settings(max_examples=80, deadline=None)
@given(
    arrays.arrays(
        np.uint8,
        st.tuples(st.integers(1, 40), st.integers(1, 40), st.just(3)),
        elements=st.sampled_from([0, 1, 7, 250, 255]) | st.integers(0, 255),
        fill=st.integers(0, 255),
    )
)
def test_small_images_of_any_content(image: np.ndarray) -> None:
    np.testing.assert_array_equal(dark_channel(image), oracle_dark(image))
    assert estimate(image) == oracle(image)


@pytest.mark.parametrize(
    "shape", [(1, 1), (1, 30), (30, 1), (14, 14), (15, 15), (25, 40), (40, 50), (70, 130), (200, 90)]
)
@pytest.mark.parametrize("levels", [2, 20, 256])
def test_images_of_all_sizes_with_few_and_many_ties(shape: tuple[int, int], levels: int) -> None:
    image = (RNG.integers(0, levels, (*shape, 3)) * (255 // (levels - 1))).astype(np.uint8)
    np.testing.assert_array_equal(dark_channel(image), oracle_dark(image))
    assert estimate(image) == oracle(image)


def test_candidates_are_ranked_as_published_wherever_they_lie() -> None:
    """Bright spots of two levels, each of 15 to 20 pixels a side, over a dim and noisy ground: some bands have none."""
    for height, width in [(16_000, 1), (1_001, 30), (300, 200), (149, 151), (150, 400)]:
        image = RNG.integers(0, 60, (height, width, 3), dtype=np.uint8)
        for _ in range(6):
            y, x, side = RNG.integers(0, height), RNG.integers(0, width), RNG.integers(15, 21)
            image[y : y + side, x : x + side] = RNG.choice([180, 200])
        expected = oracle_ranked(image)
        rows, columns = candidates(image)
        np.testing.assert_array_equal(columns * height + rows, expected)


def test_smooth_images_with_a_bright_band() -> None:
    image = np.full((120, 160, 3), 60, np.uint8)
    image[:50] = np.linspace(120, 255, 160).astype(np.uint8)[None, :, None]
    image += RNG.integers(0, 3, image.shape, dtype=np.uint8) * (image < 250)
    assert estimate(image) == oracle(image)


@pytest.mark.parametrize("level", [0, 128, 255])
def test_where_all_pixels_tie_the_first_one_counts(level: int) -> None:
    assert estimate(np.full((50, 60, 3), level, np.uint8)) == Airlight(level, level, level, 0, 0)


def test_a_single_pixel_is_its_own_airlight() -> None:
    assert estimate(np.array([[[9, 8, 7]]], np.uint8)) == Airlight(9, 8, 7, 0, 0)


def test_ties_are_broken_by_column_and_then_row() -> None:
    """Two equal bright squares: the one further left counts, though it lies further down."""
    image = np.zeros((60, 60, 3), np.uint8)
    image[2:22, 35:55] = 200
    image[35:55, 5:25] = 200
    light = estimate(image)
    assert (light.row, light.column) == (42, 12)  # 7 pixels inside its corner (35, 5)


def test_the_number_of_candidates_is_odd() -> None:
    """2000 pixels: 2 becomes 3; a plain 2 would have no middle."""
    image = np.zeros((40, 50, 3), np.uint8)
    image[:, :, :] = np.arange(50)[None, :, None]
    assert estimate(image) == oracle(image)


@pytest.mark.parametrize(
    "image",
    [np.zeros((0, 4, 3), np.uint8), np.zeros((4, 4), np.uint8), np.zeros((4, 4, 4), np.uint8), np.zeros((4, 4, 3))],
)
def test_what_is_no_colour_image_is_refused(image: np.ndarray) -> None:
    with pytest.raises(ValueError, match="image: "):
        estimate(image)


def test_overcast_light_is_not_blue_and_a_clear_sky_is() -> None:
    """Levels of blackbodies in sRGB: overcast 6,500 K and 7,000 K, clear blue sky 10,000 K and 15,000 K."""
    assert not Airlight(251, 255, 249, 0, 0).is_blue()  # both real samples
    assert not Airlight(255, 249, 254, 0, 0).is_blue()
    assert not Airlight(244, 243, 255, 0, 0).is_blue()
    assert Airlight(205, 217, 255, 0, 0).is_blue()
    assert Airlight(181, 201, 255, 0, 0).is_blue()
    assert Airlight(45, 54, 64, 0, 0).is_blue()  # the same at dusk: a share, not a number of levels
    assert not Airlight(0, 0, 0, 0, 0).is_blue()


@given(st.tuples(*[st.integers(0, 255)] * 3))
def test_grey_airlight_keeps_its_brightness_and_is_never_blue(levels: tuple[int, int, int]) -> None:
    grey = Airlight(*levels, 1, 2).grey()
    assert len(set(grey.levels)) == 1
    assert min(levels) <= grey.red <= max(levels)
    assert not grey.is_blue()
    assert grey.grey() == grey
