"""The stand-in's streets: decided by the seed alone, true to their labels, and with every class to learn."""

import numpy as np
import pytest

from foggy_synscapes.datasets.synscapes import SCENE_KEYS
from foggy_synscapes.fog.airlight import estimate
from foggy_synscapes.labels import CLASSES, LABEL_IDS, to_train_ids
from foggy_synscapes.standin.layouts import cityscapes, foggy_driving, foggy_zurich, synscapes
from foggy_synscapes.standin.render import BRIGHTEST, Scene, render
from foggy_synscapes.standin.style import BLUE_EVERY, is_blue

SIZE = (128, 256)
COUNT = 60
ID = dict(zip(CLASSES, LABEL_IDS, strict=True))


@pytest.fixture(scope="module")
def scenes() -> list[Scene]:
    """Sixty frames: thirty of Synscapes, thirty of Cityscapes."""
    half = COUNT // 2
    real = [cityscapes.scene(2019, SIZE, "train", k)[0] for k in range(half)]
    return [synscapes.scene(2019, SIZE, k) for k in range(half)] + real


def test_a_frame_depends_on_its_seed_alone() -> None:
    first = render((7, 1, 4), (48, 96), real=True)
    render((7, 1, 5), (48, 96), real=False)
    again = render((7, 1, 4), (48, 96), real=True)
    assert np.array_equal(first.rgb, again.rgb)
    assert np.array_equal(first.depth, again.depth)
    assert np.array_equal(first.instances, again.instances)
    assert first.scene == again.scene
    assert first.instance == again.instance
    assert not np.array_equal(first.rgb, render((8, 1, 4), (48, 96), real=True).rgb)


def test_streams_share_no_scene() -> None:
    streams = {synscapes.STREAM, *cityscapes.STREAMS.values(), foggy_driving.FINE, foggy_driving.COARSE}
    streams.add(foggy_zurich.STREAM)
    assert len(streams) == 6
    depths = [render((2019, stream, 0), (32, 64), real=True).depth.tobytes() for stream in streams]
    assert len(set(depths)) == len(streams)


def test_domains_show_the_same_street() -> None:
    smooth, rough = (render((3, 1, 4), (64, 128), real=real) for real in (False, True))
    assert np.array_equal(smooth.label_ids, rough.label_ids)
    assert not np.array_equal(smooth.rgb, rough.rgb)
    road = (smooth.label_ids == ID["road"])[:, 1:]
    fine = [np.abs(np.diff(scene.rgb.astype(int), axis=1))[road].mean() for scene in (smooth, rough)]
    assert fine[1] > 1.2 * fine[0]


def test_every_pixel_has_a_label_and_a_depth(scenes: list[Scene]) -> None:
    for scene in scenes:
        assert set(np.unique(scene.label_ids)) <= {1, 4, *LABEL_IDS}
        assert np.isfinite(scene.depth).all()
        assert scene.depth.min() > 1


def test_nothing_stands_between_the_street_and_the_sky_dome(scenes: list[Scene]) -> None:
    for scene in scenes:
        sky = scene.label_ids == ID["sky"]
        assert scene.depth[~sky].max() < 500
        if sky.any():
            assert scene.depth[sky].min() >= 7900
            assert scene.depth[sky].max() <= 8900


def test_depth_is_planar(scenes: list[Scene]) -> None:
    for scene in scenes[:5]:
        rig, road = scene.rig, scene.label_ids == ID["road"]
        assert road.any()
        dx, dy, dz = rig.rays()
        height = rig.z + scene.depth * dy  # of the point seen above the road's plane
        assert np.abs(height[road]).max() < 1e-3
        forward = rig.axes[2]
        planar = scene.depth * (dx * forward[0] + dy * forward[1] + dz * forward[2])
        assert np.abs(planar[road] / scene.depth[road] - 1).max() < 1e-5


def test_every_class_is_frequent_enough_to_be_learned(scenes: list[Scene]) -> None:
    pixels, images = np.zeros(19), np.zeros(19)
    for scene in scenes:
        counts = np.bincount(to_train_ids(scene.label_ids, "scene").ravel(), minlength=256)[:19]
        pixels += counts
        images += counts > 20
    share = dict(zip(CLASSES, pixels / pixels.sum(), strict=True))
    assert min(share.values()) > 0.0015, share
    assert images.min() > 0.15 * COUNT, dict(zip(CLASSES, images, strict=True))
    assert share["road"] < 0.5


def test_each_block_of_frames_has_one_blue_sky(scenes: list[Scene]) -> None:
    blue = [is_blue((2019, 1), frame) for frame in range(20 * BLUE_EVERY)]
    assert all(sum(blue[k : k + BLUE_EVERY]) == 1 for k in range(0, len(blue), BLUE_EVERY))
    for k, scene in enumerate(scenes[: COUNT // 2]):
        low, high = (5, 6) if blue[k] else (2, 5)
        assert low < scene.scene["sky_contrast"] <= high


def test_atmospheric_light_is_blue_only_under_high_contrast(scenes: list[Scene]) -> None:
    blue, white = [], []
    for scene in scenes[: COUNT // 2]:
        (blue if scene.scene["sky_contrast"] > 5 else white).append(estimate(scene.rgb))
    assert len(blue) >= 3
    assert all(light.is_blue() for light in blue)
    # Where hardly any sky is seen, the light is that of something else: a few frames, as in real data.
    near_white = [not light.is_blue() and min(light.levels) > 200 for light in white]
    assert sum(near_white) > 0.9 * len(white)


def test_the_brightest_sky_is_that_of_the_published_samples(scenes: list[Scene]) -> None:
    whitest = np.concatenate([scene.rgb[scene.label_ids == ID["sky"]] for scene in scenes[: COUNT // 2]]).max(axis=0)
    assert bytes(whitest).hex() == BRIGHTEST


def test_scene_keys_count_what_is_seen(scenes: list[Scene]) -> None:
    names = {"cars": "car", "trucks": "truck", "buses": "bus", "trains": "train", "pedestrians": "person"}
    for scene in scenes:
        assert tuple(scene.scene) == SCENE_KEYS
        assert all(np.isfinite(value) for value in scene.scene.values())
        seen = [int(number) // 10000 for number in np.unique(scene.instances) if number]
        for kind, name in names.items():
            assert scene.scene[f"num_{kind}"] == seen.count(ID[name])
            assert (scene.scene[f"dist_{kind}_mean"] > 0) == (ID[name] in seen)
        riders = scene.scene["num_bicyclists"] + scene.scene["num_motorcyclists"]
        assert riders == seen.count(ID["rider"])
        assert (scene.scene["fence_presence"] > 0) == (scene.scene["fence_height"] > 0)
        assert scene.scene["parking_angle"] in (0, 45, 90)


def test_instances_project_from_metadata_into_class_and_depth(scenes: list[Scene]) -> None:
    checked = 0
    for scene in scenes:
        numbers = {int(number) for number in np.unique(scene.instances) if number}
        assert all({int(key) for key in part} == numbers for part in scene.instance.values())
        for number in numbers:
            _check_instance(scene, number)
            checked += 1
    assert checked > 5 * COUNT


def _check_instance(scene: Scene, number: int) -> None:
    rows, columns = scene.label_ids.shape
    key, mine = str(number), scene.instances == number
    box = scene.instance["bbox2d"][key]
    assert (scene.label_ids[mine] == scene.instance["class"][key]).all()
    assert scene.instance["class"][key] == number // 10000
    depth = scene.depth[mine]
    assert box["zmin"] - 1e-3 <= depth.min()
    assert depth.max() <= box["zmax"] + 1e-3
    y, x = np.nonzero(mine)
    left, right, top, bottom = box["xmin"] * columns, box["xmax"] * columns, box["ymin"] * rows, box["ymax"] * rows
    assert left - 1e-6 <= x.min() < x.max() + 1 <= right + 1e-6
    assert top - 1e-6 <= y.min() < y.max() + 1 <= bottom + 1e-6
    if scene.instance["occluded"][key] == 0:
        assert (left, right) == pytest.approx((x.min(), x.max() + 1))
        assert (top, bottom) == pytest.approx((y.min(), y.max() + 1))
    assert 0 <= scene.instance["truncated"][key] < 1
    corners = _corners(scene.instance["bbox3d"][key])
    assert corners[:, 2].min() - 0.01 <= box["zmin"]
    assert box["zmax"] <= corners[:, 2].max() + 0.01
    if corners[:, 2].min() > 0.5:
        rig = scene.rig
        u, v = (
            corners[:, 0] / corners[:, 2] * rig.fx + rig.u0,
            corners[:, 1] / corners[:, 2] * rig.fy + rig.v0,
        )
        assert u.min() - 1 <= left < right <= u.max() + 1
        assert v.min() - 1 <= top < bottom <= v.max() + 1


def _corners(box: dict[str, list[float]]) -> np.ndarray:
    origin, x, y, z = (np.array(box[name]) for name in ("origin", "x", "y", "z"))
    return np.array([origin + a * x + b * y + c * z for a in (0, 1) for b in (0, 1) for c in (0, 1)])
