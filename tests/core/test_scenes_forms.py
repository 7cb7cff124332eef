"""What real datasets add to exact truth: measured disparity, coarse labels, instance ids, fog."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from foggy_synscapes.camera import Camera
from foggy_synscapes.fog.frame import foggy_frame
from foggy_synscapes.fog.geometry import rays
from foggy_synscapes.standin import fog as haze
from foggy_synscapes.standin import stereo
from foggy_synscapes.standin.canvas import FARTHEST
from foggy_synscapes.standin.layouts import cityscapes, foggy_cityscapes, foggy_driving, foggy_zurich, synscapes

SIZE = (96, 192)


@pytest.fixture(scope="module")
def stereo_frames() -> list:
    return [cityscapes.scene(2019, SIZE, "train", k) for k in range(6)]


def test_disparity_is_focal_length_times_baseline_over_depth(stereo_frames: list) -> None:
    for scene, stored in stereo_frames:
        street = (stored > 0) & (scene.depth < FARTHEST)
        measured = (stored[street].astype(float) - 1) / 256
        exact = scene.rig.fx * stereo.BASELINE / scene.depth[street]
        error = measured - exact
        assert abs(np.median(error)) < 0.01
        scale = SIZE[1] / stereo.REFERENCE_COLUMNS
        assert 0.5 < error[exact > 1].std() / (stereo.MATCHING_ERROR * scale) < 1.5


def test_disparity_has_holes_but_not_everywhere(stereo_frames: list) -> None:
    for scene, stored in stereo_frames:
        street = (scene.depth < FARTHEST) & (scene.label_ids != 1)
        assert 0.05 < (stored[street] == 0).mean() < 0.5
        assert (stored[scene.label_ids == 1] == 0).all()
        sky = scene.depth > FARTHEST
        if sky.sum() > 500:
            assert (stored[sky] == 0).mean() > 0.5


def test_completion_keeps_what_was_measured_and_fills_the_rest() -> None:
    stored = np.array([[0, 0, 0, 0], [0, 513, 0, 257], [0, 0, 0, 0]], dtype=np.uint16)
    assert stereo.complete(stored).tolist() == [[2, 2, 1, 1]] * 3
    with pytest.raises(ValueError, match="stored"):
        stereo.complete(np.zeros((2, 2), np.uint16))


def test_fog_from_stereo_is_imperfect_but_close(stereo_frames: list) -> None:
    for scene, stored in stereo_frames:
        clear, light, dense = haze.from_stereo(scene, stored, [1e-9, 0.005, 0.02])
        assert np.array_equal(clear, scene.rgb)
        length = haze.ray_length(stereo.to_depth(stereo.complete(stored), scene.rig.fx), scene.rig)
        exact = haze.ray_length(scene.depth, scene.rig)
        wrong = np.abs(np.exp(-0.02 * length) - np.exp(-0.02 * exact))
        assert 0.001 < wrong.mean() < 0.25
        assert dense.std() < light.std()


def test_distances_and_light_agree_with_the_fog_core(stereo_frames: list) -> None:
    # The stand-in has its own few lines of fog, so that a change of the fog core does not draw new scenes.
    scene, stored = stereo_frames[0]
    camera = Camera(**scene.rig.metadata()["intrinsic"])
    exact = scene.depth * rays(camera, "exact").factor()
    assert np.allclose(haze.ray_length(scene.depth, scene.rig), exact, rtol=1e-12)
    depth = stereo.to_depth(stereo.complete(stored), scene.rig.fx).astype(np.float32)
    by_core = foggy_frame(scene.rgb, depth, camera, [0.01], "exact")[0].astype(int)
    assert np.abs(haze.from_stereo(scene, stored, [0.01])[0] - by_core).max() < 30


def test_refined_frames_have_no_blue_sky() -> None:
    plan = SimpleNamespace(seed=2019, cityscapes=SimpleNamespace(train=40, val=9))
    plan.foggy_cityscapes = SimpleNamespace(train=20, val=1)
    chosen = foggy_cityscapes.refined(plan, plan.foggy_cityscapes)
    assert len(set(chosen)) == 21
    assert all(cityscapes.scene(2019, (32, 64), *clear)[0].scene["sky_contrast"] < 5 for clear in chosen[:5])
    plan.foggy_cityscapes.train = 40
    with pytest.raises(ValueError, match="40 refined"):
        foggy_cityscapes.refined(plan, plan.foggy_cityscapes)


def test_coarse_labels_are_right_where_they_say_anything() -> None:
    scene = synscapes.scene(2019, SIZE, 0)
    coarse = foggy_driving.coarsen(scene.label_ids)
    labelled = coarse > 0
    assert 0.5 < labelled.mean() < 0.95
    assert (coarse == scene.label_ids)[labelled].mean() > 0.98
    borders = scene.label_ids[:, 1:] != scene.label_ids[:, :-1]
    assert labelled[:, 1:][borders].mean() < 0.3


def test_instance_numbers_survive_their_colours() -> None:
    numbers = np.array([[0, 240001, 330012]], dtype=np.uint32)
    red, green, blue = np.moveaxis(synscapes.instance_colours(numbers).astype(int), -1, 0)
    assert (red + 256 * green + 65536 * blue).tolist() == numbers.tolist()
    scene = replace(synscapes.scene(2019, (32, 64), 0), label_ids=np.array([[7, 24, 33]], np.uint8), instances=numbers)
    assert scene.instance_ids().tolist() == [[7, 24001, 33012]]


def test_test_fog_is_of_densities_that_training_does_not_use() -> None:
    assert not {0.005, 0.01, 0.02, 0.03, 0.06} & {*foggy_driving.BETAS, *foggy_zurich.BETAS}
    thin, dense = (haze.photograph((2019, 13, 0), SIZE, foggy_zurich.BETAS[k], trains=False) for k in (0, 4))
    assert np.array_equal(thin.label_ids, dense.label_ids)
    assert dense.rgb.std() < thin.rgb.std()
    assert foggy_zurich.photograph(2019, SIZE, 0).rgb.shape == (108, 192, 3)


def test_foggy_zurich_has_no_train() -> None:
    for number in range(12):
        assert not (foggy_zurich.photograph(2019, (32, 64), number).label_ids == 31).any()


def test_foggy_driving_images_differ_in_size() -> None:
    assert len({foggy_driving.photograph(2019, (32, 64), True, number).rgb.shape for number in range(8)}) > 2
