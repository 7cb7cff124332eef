"""Rays: the published formula, the exact one, and crops."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from foggy_synscapes.camera import Camera
from foggy_synscapes.fog.geometry import rays, straight

SYNSCAPES = Camera(fx=1590.83437, fy=1592.79032, u0=771.31406, v0=360.79945, resx=1440, resy=720)
NEAR = Camera(fx=3.0, fy=6.0, u0=2.0, v0=1.0, resx=4, resy=2)


def test_paper_counts_pixels_from_one_and_takes_fx_on_both_axes() -> None:
    factor = rays(NEAR).factor()
    assert factor[0, 1] == 1.0  # column 2, row 1: the principal point
    assert factor[1, 3] == np.sqrt((9 + 4 + 1) / 9)


def test_exact_takes_pixel_centres_and_both_focal_lengths() -> None:
    factor = rays(NEAR, "exact").factor()
    assert factor[1, 3] == np.sqrt(1 + (1.5 / 3) ** 2 + (0.5 / 6) ** 2)
    assert rays(Camera(1.0, 1.0, 0.5, 0.5, 1, 1), "exact").factor() == 1.0


def test_the_two_geometries_differ_by_less_than_a_thousandth_on_the_real_camera() -> None:
    paper, exact = rays(SYNSCAPES).factor(), rays(SYNSCAPES, "exact").factor()
    assert paper.shape == exact.shape == (720, 1440)
    assert 0 < np.abs(paper / exact - 1).max() < 1e-3
    assert paper.min() >= 1
    assert exact.min() >= 1


@given(
    top=st.integers(0, 5), left=st.integers(0, 5), height=st.integers(1, 5), width=st.integers(1, 5),
    geometry=st.sampled_from(["paper", "exact"]),
)  # fmt: skip
def test_a_crop_has_the_rays_of_a_camera_with_the_shifted_axis(top, left, height, width, geometry) -> None:
    camera = Camera(fx=13.0, fy=14.0, u0=4.7, v0=3.2, resx=10, resy=10)
    shifted = Camera(13.0, 14.0, 4.7 - left, 3.2 - top, width, height)
    cropped = rays(camera, geometry).crop(top, left, height, width)
    np.testing.assert_allclose(cropped.factor(), rays(shifted, geometry).factor(), rtol=1e-14)


def test_another_geometry_is_refused() -> None:
    with pytest.raises(ValueError, match="geometry: 'papier', expected paper or exact"):
        rays(NEAR, "papier")


def test_straight_rays_leave_distances_as_they_are() -> None:
    assert (straight((2, 3)).factor() == np.ones((2, 3))).all()
