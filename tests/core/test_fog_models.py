"""Every fog model against its analytic case; values out of range are refused by name and range."""

import math

import numpy as np
import pytest

from foggy_synscapes.camera import Camera
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.fog import ladder, models, uneven
from foggy_synscapes.fog.geometry import Rays, rays, straight
from foggy_synscapes.fog.models import none
from foggy_synscapes.fog.optics import foggy_images, transmittance
from foggy_synscapes.fog.radiance import encoded, linear

CAMERA = Camera(fx=140.0, fy=140.0, u0=63.0, v0=30.0, resx=128, resy=64)
ALONG = rays(CAMERA, "exact")
LIGHT = (230, 235, 240)
BETAS = [0.0, 0.005, 0.02, 0.06]
LADDER = ["none", "homogeneous", "layered", "heterogeneous", "surround", "auto"]


def street(seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """An image and planar depth of a road below, and walls and sky above."""
    rng = np.random.default_rng(seed)
    assert ALONG.down is not None
    depth = np.repeat(np.clip(1.2 / np.maximum(ALONG.down + 0.04, 1e-3), 3, 60)[:, None], 128, axis=1)
    depth = np.where(rng.random((64, 128)) < 0.5, depth, depth * 0.7)
    depth[:20] = 8000
    return rng.integers(0, 256, (64, 128, 3), dtype=np.uint8), depth.astype(np.float32)


def levels(t: np.ndarray, image: np.ndarray) -> np.ndarray:
    """Fog of a transmittance by the published formula, not rounded."""
    return t[..., None] * image + (1 - t[..., None]) * np.array(LIGHT)


@pytest.mark.parametrize("name", LADDER)
def test_no_fog_is_the_image_and_several_betas_are_each_alone(name: str) -> None:
    image, depth = street()
    foggy = models.apply(name, image, depth, BETAS, CAMERA, airlight=LIGHT)
    assert foggy.dtype == np.uint8
    assert np.array_equal(foggy[0], image)
    if name != "heterogeneous":  # how far its noise is looked at is decided by the lowest beta
        alone = models.apply(name, image, depth, BETAS[2], CAMERA, airlight=LIGHT)
        assert np.array_equal(foggy[2], alone)


@pytest.mark.parametrize("name", ["homogeneous", "heterogeneous", "surround"])
def test_an_image_of_the_airlight_stays_as_it_is(name: str) -> None:
    _, depth = street()
    image = np.full((64, 128, 3), LIGHT, np.uint8)
    assert np.array_equal(models.apply(name, image, depth, 0.02, CAMERA, airlight=LIGHT), image)


def test_the_default_is_the_compiled_path_itself() -> None:
    assert models.chosen("homogeneous") is models.MODELS["homogeneous"]
    assert models.MODELS["homogeneous"].images is foggy_images


def test_layered_distance_is_the_integral_of_the_density() -> None:
    nodes, weights = np.polynomial.legendre.leggauss(64)
    _, depth = street()
    depth = depth[:, ::16].astype(float)
    way = Rays(ALONG.rows, ALONG.columns[::16], ALONG.scale, ALONG.down, np.asarray(ALONG.right)[::16])
    depth[:20] = 150.0  # the quadrature needs a finite end
    height, camera, pitch = 20.0, 1.2, 0.04
    found = uneven.layered(depth, way, height, camera, pitch)
    assert way.down is not None
    rise = (-way.down * math.cos(pitch) - math.sin(pitch))[:, None]
    share = (nodes + 1) / 2
    heights = np.maximum(rise * depth, -camera)[..., None] * share + camera
    exact = depth * way.factor() * (np.exp(-heights / height) * weights / 2).sum(axis=-1)
    assert np.abs(found / exact - 1).max() < 1e-12


@pytest.mark.parametrize(("scale_height", "pitch"), [(20.0, 0.038), (5.0, -0.2), (0.5, 0.3), (1e5, 0.0)])
def test_layered_images_are_those_of_the_formula(scale_height: float, pitch: float) -> None:
    image, depth = street()
    depth[0] = np.inf
    distance = uneven.layered(depth, ALONG, scale_height, 1.0, pitch)
    values = {"scale_height": scale_height, "camera_height": 1.0, "pitch": pitch}
    for beta in BETAS[1:]:
        foggy = models.apply("layered", image, depth, beta, ALONG, airlight=LIGHT, **values)
        assert np.abs(foggy - levels(transmittance(distance, beta), image)).max() < 0.51


def test_layered_fog_without_end_is_homogeneous() -> None:
    image, depth = street()
    layered = models.apply("layered:scale_height=100000", image, depth[:, :], 0.02, CAMERA, airlight=LIGHT)
    plain = models.apply("homogeneous", image, depth, 0.02, CAMERA, airlight=LIGHT)
    assert np.abs(layered.astype(int) - plain)[20:].max() <= 1


def test_the_sky_shows_through_a_layer_of_fog_and_not_through_homogeneous_fog() -> None:
    image = np.zeros((64, 128, 3), np.uint8)
    depth = np.full((64, 128), np.inf, np.float32)
    up = models.apply("layered:scale_height=2,pitch=0", image, depth, 0.02, CAMERA, airlight=LIGHT)[0, 64]
    # Straight through: the optical depth is beta H over the sine of the elevation.
    sine = (30 - 1) / math.sqrt(140**2 + 29**2 + 2**2)
    assert abs(int(up[0]) - (1 - math.exp(-0.02 * 2 * math.exp(-1.22 / 2) / sine)) * LIGHT[0]) < 1
    assert (models.apply("homogeneous", image, depth, 0.02, CAMERA, airlight=LIGHT) == LIGHT).all()


def test_heterogeneous_fog_without_contrast_is_homogeneous() -> None:
    image, depth = street()
    foggy = models.apply("heterogeneous:contrast=0", image, depth, BETAS, CAMERA, airlight=LIGHT)
    plain = models.apply("homogeneous", image, depth, BETAS, CAMERA, airlight=LIGHT)
    assert np.abs(foggy.astype(int) - plain).max() <= 1
    assert (foggy != plain).mean() < 1e-3


def test_heterogeneous_integral_is_that_of_numpy_and_converges() -> None:
    _, depth = street()
    depth[depth > 1000] = 60  # so that steps are short
    model = models.chosen("heterogeneous:steps=2048")
    many = model.transmittances(depth, ALONG, [0.02])[0].astype(float)
    few = models.chosen("heterogeneous:steps=16").transmittances(depth, ALONG, [0.02])[0]
    even = models.MODELS["homogeneous"].transmittances(depth, ALONG, [0.02])[0]
    assert np.abs(many - few).max() <= 2
    assert np.abs(many - even).max() > 5  # there is something to integrate


def test_noise_is_periodic_seeded_and_of_mean_zero() -> None:
    grid = uneven.noise(3)
    assert grid.shape == (uneven.GRID,) * 3
    assert abs(float(grid.mean(dtype=np.float64))) < 1e-5
    assert float(np.abs(grid).max()) == 1.0
    assert not np.array_equal(grid, uneven.noise(4))
    steps = [float(np.abs(np.diff(grid, axis=axis)).max()) for axis in range(3)]
    across = [float(np.abs(np.take(grid, 0, axis) - np.take(grid, -1, axis)).max()) for axis in range(3)]
    assert max(across) <= 1.2 * max(steps)


def test_surround_without_a_share_is_koschmieders_law_in_linear_light() -> None:
    image, depth = street()
    light = linear(np.array(LIGHT, np.uint8))
    for beta in BETAS[1:]:
        t = np.exp(-beta * depth * ALONG.factor())[..., None]
        exact = encoded(light + t * (linear(image) - light))
        foggy = models.apply("surround:share=0", image, depth, beta, ALONG, airlight=LIGHT)
        assert np.abs(foggy - exact).max() < 0.6  # half a level of rounding, and the table's step at the dark end


def test_surround_of_one_colour_is_exact() -> None:
    """With R the same everywhere and ground of it below, the blur changes nothing far from the horizon's edge."""
    depth = np.full((64, 128), 1e5, np.float32)
    image = np.full((64, 128, 3), 60, np.uint8)
    foggy = models.apply("surround:share=1,blur=1,surround=ground", image, depth, 0.02, ALONG, airlight=LIGHT)
    assert np.abs(foggy[45:60, 40:90].astype(int) - 60).max() <= 1


def test_surround_mirrors_with_the_image() -> None:
    image, depth = street()
    image[10:40, 20:50] = 0
    middle = rays(Camera(fx=140.0, fy=140.0, u0=64.0, v0=30.0, resx=128, resy=64), "exact")
    foggy = models.apply("surround", image, depth, 0.02, middle, airlight=LIGHT)
    flipped = models.apply("surround", image[:, ::-1], depth[:, ::-1], 0.02, middle, airlight=LIGHT)
    assert np.abs(foggy[:, ::-1].astype(int) - flipped).max() <= 1


def test_none_is_enough_exactly_where_no_level_would_change() -> None:
    image, depth = street()
    image[:20] = LIGHT  # an infinite sky has to be the airlight
    depth[:20] = np.inf
    for beta in (1e-6, 1e-5, 3e-5, 1e-4, 1e-3):
        changed = models.apply("homogeneous", image, depth, beta, ALONG, airlight=LIGHT) != image
        assert none.is_enough(image, depth, ALONG, LIGHT, beta) == (not changed.any()), beta
    image[0, 0] = 0
    assert not none.is_enough(image, depth, ALONG, LIGHT, 1e-9)


def test_airlight_is_estimated_grey_or_stated() -> None:
    image = np.full((64, 128, 3), (150, 190, 235), np.uint8)
    depth = np.full((64, 128), np.inf, np.float32)
    for text, wanted in (("estimated", (150, 190, 235)), ("grey", (183, 183, 183)), ("10/20/30", (10, 20, 30))):
        foggy = models.apply(f"homogeneous:airlight={text}", image, depth, 0.02, CAMERA)
        assert (foggy == wanted).all()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("layered:scale_height=-1", r"layered: scale_height is -1 m, expected at least 0\.5, at most 100000 m"),
        ("layered:pitch=2", r"pitch is 2 rad, expected above -1\.57, below 1\.57 rad"),
        ("layered:height=2", r"no value 'height'; there are airlight, scale_height, camera_height, pitch"),
        ("surround:share=1.2", r"share is 1\.2, expected at least 0, at most 1"),
        ("heterogeneous:contrast=2", r"contrast is 2, expected at least 0, at most 1"),
        ("auto:tolerance=0", r"tolerance is 0 levels, expected above 0, at most 255 levels"),
        (
            "homogeneous:airlight=300/1/1",
            r"airlight is \[300, 1, 1\], expected estimated, grey or three levels from 0 to 255",
        ),
        ("heterogeneous:steps=1.5", r"steps is 1\.5, expected a whole number, at least 1, at most 4096"),
        ("surround:surround=sea", "surround is sea, expected open or ground"),
        ("layered:scale_height=nan", "scale_height is nan m, expected at least"),
        ("layered:", "expected NAME or NAME:KEY=VALUE"),
    ],
)
def test_values_out_of_range_are_named_with_the_range(text: str, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        models.chosen(text)


def test_a_blur_wider_than_the_image_and_rays_without_directions_are_refused() -> None:
    image, depth = street()
    with pytest.raises(ValueError, match=r"blur: 50 degrees, wider than the image: expected up to 42\.\d degrees"):
        models.apply("surround:blur=50", image, depth, 0.02, CAMERA)
    for name in ("layered", "heterogeneous", "surround"):
        with pytest.raises(ValueError, match="without directions"):
            models.apply(name, image, depth, 0.02, straight((64, 128)), airlight=LIGHT)
    with pytest.raises(
        FoggyError, match="'thick' is no fog model; there are auto, heterogeneous, homogeneous, layered"
    ):
        models.chosen("thick")


def test_spelling_keeps_what_differs_from_the_defaults_and_comes_back() -> None:
    text = models.spelling("layered", {"scale_height": 12.5, "airlight": [1, 2, 3], "pitch": 0.038})
    assert text == "layered:airlight=1/2/3,scale_height=12.5"
    assert models.spelt(text) == text


def test_auto_takes_the_cheapest_model_that_the_atlas_bounds_by_the_tolerance() -> None:
    image, depth = street()
    known = ladder.factors()
    for beta in BETAS[1:]:
        share = ladder.lost(depth, ALONG, beta)
        bounds = {name: ladder.bound(name, "open", beta, share, known) for name in ladder.RUNGS}
        for tolerance in (0.01, 3.0, 8.0, 20.0, 200.0):
            choose = models.chosen(f"auto:tolerance={tolerance}").choose
            assert choose is not None
            choice = choose(image, depth, ALONG, LIGHT, beta)
            fitting = [name for name in ladder.RUNGS if bounds[name] <= tolerance]
            taken = fitting[0] if fitting else min(bounds, key=lambda name: bounds[name])
            dim = f"homogeneous:airlight={'/'.join(map(str, ladder.dimmed(LIGHT, 'open')))}"
            assert choice.model == (dim if taken == ladder.DIMMED else taken)
            assert ("no model is enough" in choice.why) == (not fitting)
            foggy = models.apply(f"auto:tolerance={tolerance}", image, depth, beta, ALONG, airlight=LIGHT)
            assert np.array_equal(foggy, models.apply(choice.model, image, depth, beta, ALONG, airlight=LIGHT))


def test_a_tolerance_without_an_atlas_is_refused(tmp_path) -> None:
    with pytest.raises(FoggyError, match=r"A tolerance needs an atlas: foggy atlas makes it"):
        ladder.factors(tmp_path / "bounds.csv")
    (tmp_path / "other.csv").write_text("a,b\n1,2\n")
    with pytest.raises(FoggyError, match=r"no atlas of fog models, expected columns surround, model, beta, factor"):
        ladder.factors(tmp_path / "other.csv")
