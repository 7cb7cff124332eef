"""The functions of the package: equal to the commands, and every wrong argument named."""

import inspect
import json
from pathlib import Path

import numpy as np
import pytest
from fog_frames import CAMERA, SIZE, camera_json, content, write_frames

import foggy_synscapes as fs
from foggy_synscapes import Camera, api, fog
from foggy_synscapes.camera import Camera as CameraOfTheCore
from foggy_synscapes.cli import main
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.fog import optics
from foggy_synscapes.io.images import encode_png, read_ids, read_rgb


@pytest.fixture
def root(tmp_path: Path) -> Path:
    return write_frames(tmp_path / "synscapes", 1)


@pytest.mark.parametrize("geometry", ["paper", "exact"])
def test_fog_is_that_of_the_command(root: Path, tmp_path: Path, geometry: str) -> None:
    """Of arrays and of files, in float32 and float64, one beta and several."""
    options = ["--beta", "0.01", "--beta", "0.03", "--geometry", geometry, "--out", str(tmp_path / "out")]
    assert main(["fog", "--synscapes", str(root), *options]) == 0
    written = [read_rgb(tmp_path / f"out/beta_{beta}/foggy_img/00001_beta_{beta}.png") for beta in ("0.01", "0.03")]
    image, depth = content(1)
    files = root / "img/rgb/1.png", str(root / "img/depth/1.exr")
    cases = [(image, depth, CAMERA), (image, depth.astype(np.float64), CAMERA), (*files, root / "meta/1.json")]
    for clear, metres, camera in cases:
        np.testing.assert_array_equal(fog(clear, metres, [0.01, 0.03], camera, geometry=geometry), written)
        np.testing.assert_array_equal(fog(clear, metres, 0.03, camera, geometry=geometry), written[1])
        np.testing.assert_array_equal(fog(clear, metres, beta=np.float32(0), camera=camera), image)


def test_the_name_fog_is_a_package_that_can_be_called() -> None:
    import foggy_synscapes.fog.geometry as geometry

    assert fs.fog is fog
    assert inspect.signature(fog) == inspect.signature(api.fog)
    assert "attenuation coefficient, 1/m" in fog.__doc__
    assert fog.optics is optics
    assert geometry.straight((1, 1)).shape == (1, 1)
    assert fs.Camera is Camera is CameraOfTheCore


def test_every_name_is_there_documented_and_shown(capsys) -> None:
    assert sorted(fs.__all__) == sorted(api.__all__)
    assert {*fs.__all__} <= {*dir(fs)}
    for name in set(fs.__all__) - {"Airlight", "Camera", "FoggyError", "fog"}:
        assert getattr(fs, name) is getattr(api, name)
        assert ">>> " in getattr(api, name).__doc__
        assert "Raises" in getattr(api, name).__doc__
    with pytest.raises(AttributeError, match="no attribute 'fogg'"):
        fs.fogg  # noqa: B018


def test_transmittance_of_depth_is_that_of_its_distance(root: Path) -> None:
    _, depth = content(1)
    along = fs.distance(depth, CAMERA, geometry="exact")
    assert (along >= depth).all()
    np.testing.assert_array_equal(
        fs.transmittance(depth, [0.01, 0.02], CAMERA, geometry="exact"),
        [fs.transmittance(along, 0.01), fs.transmittance(along, 0.02)],
    )
    np.testing.assert_array_equal(
        fs.transmittance(root / "img/depth/1.exr", 0.02, root / "meta/1.json"), fs.transmittance(depth, 0.02, CAMERA)
    )


def test_airlight_is_that_of_the_image_or_the_one_that_is_given() -> None:
    image, depth = content(1)
    light = fs.airlight(image)
    assert light.levels == (251, 255, 249)
    for given in (light, light.levels, np.array(light.levels)):
        np.testing.assert_array_equal(fog(image, depth, 0.02, CAMERA, airlight=given), fog(image, depth, 0.02, CAMERA))
    assert (fog(image, depth, 10.0, CAMERA, airlight=(1, 2, 3)) == (1, 2, 3)).all()


def test_visibility_and_attenuation_are_inverse() -> None:
    betas = np.array([[0.005, 0.01], [0.02, 0.06]])
    np.testing.assert_allclose(fs.attenuation(fs.visibility(betas)), betas)
    assert isinstance(fs.visibility(0.01), float)


IMAGE, DEPTH = content(1)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"camera": None}, "camera: missing; it turns depth into distance"),
        ({"camera": Camera(44, 45, 20, 11, 80, 48)}, "camera: of 80 x 48 pixels, but depth has 40 x 24"),
        ({"depth": DEPTH.astype(np.uint16)}, "depth: uint16 .* expected float32 or float64"),
        ({"depth": -DEPTH}, "negative or not a number"),
        ({"depth": DEPTH[0]}, r"expected float32 \(H, W\)"),
        ({"depth": DEPTH[:8]}, "camera: of 40 x 24 pixels, but depth has 40 x 8"),
        ({"image": IMAGE[..., 0]}, r"expected uint8 \(H, W, 3\)"),
        ({"image": IMAGE / 255}, r"expected uint8 \(H, W, 3\)"),
        ({"image": IMAGE[:8]}, "shapes differ"),
        ({"beta": -0.01}, "beta: -0.01"),
        ({"beta": [[0.01]]}, "beta: shape"),
        ({"beta": np.nan}, "beta: nan"),
        ({"airlight": (300, 0, 0)}, "three levels from 0 to 255"),
        ({"airlight": (1, 2)}, "expected three levels"),
        ({"geometry": "flat"}, "geometry: 'flat'"),
        ({"depth_is": "planar"}, "depth_is: 'planar'"),
    ],
)
def test_a_wrong_argument_of_fog_is_named(arguments: dict, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        fog(**{"image": IMAGE, "depth": DEPTH, "beta": 0.01, "camera": CAMERA, **arguments})


def test_a_file_that_is_missing_is_named(tmp_path: Path) -> None:
    with pytest.raises(FoggyError, match=r"nothing\.png: missing"):
        fog(tmp_path / "nothing.png", DEPTH, 0.01, CAMERA)
    with pytest.raises(FoggyError, match=r"nothing\.json"):
        fog(IMAGE, DEPTH, 0.01, tmp_path / "nothing.json")
    with pytest.raises(FoggyError, match="'thick' is no fog model; there are"):
        fog(IMAGE, DEPTH, 0.01, CAMERA, model="thick")
    with pytest.raises(ValueError, match="camera: missing; a depth file"):
        fs.transmittance(tmp_path / "a.exr")


def maps(seed: int, count: int = 3) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 19, (count, *SIZE)).astype(np.int64)


def test_scores_of_arrays_are_those_of_folders(tmp_path: Path) -> None:
    truth, guess = maps(0), maps(1)
    truth[:, 0] = 255  # tells that these are trainIds
    for folder, ids in (("labels", truth), ("predictions", guess)):
        (tmp_path / folder).mkdir()
        for number, each in enumerate(ids):
            (tmp_path / folder / f"{number}.png").write_bytes(encode_png(each.astype(np.uint8)))
    options = ["--predictions", str(tmp_path / "predictions"), "--labels", str(tmp_path / "labels")]
    assert main(["evaluate", *options, "--out", str(tmp_path / "metrics.json")]) == 0
    written = json.loads((tmp_path / "metrics.json").read_text())
    assert fs.score(str(tmp_path / "predictions"), tmp_path / "labels") == written
    assert fs.score(guess, truth) == fs.score([*guess], truth.astype(np.uint8)) == written
    assert read_ids(tmp_path / "labels/0.png").shape == SIZE


@pytest.mark.parametrize(
    ("predictions", "labels", "message"),
    [
        (maps(0), maps(1, count=2), "2 and 3 maps, expected as many of each"),
        (maps(0)[0], maps(1)[0, :5], r"predictions\[0\]: \(24, 40\), but its label map has \(5, 40\)"),
        (maps(0) / 2, maps(1), r"predictions\[0\]: float64"),
        (maps(0) - 1, maps(1), r"predictions\[0\]: ids from -1 to"),
        (maps(0)[0, 0], maps(1), "predictions: shape"),
        (np.zeros((2, 2), int), np.zeros((2, 2), int), "encoding='trainIds' or encoding='labelIds'"),
        ("folder", maps(1), "expected two folders, or arrays on both sides"),
    ],
)
def test_arrays_that_cannot_be_scored_are_named(predictions: object, labels: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        fs.score(predictions, labels)


def test_depth_needs_a_baseline() -> None:
    view = np.zeros((*SIZE, 3), np.uint8)
    with pytest.raises(ValueError, match="baseline: missing"):
        fs.complete(view, view, np.ones(SIZE, np.uint16), CAMERA)


def test_a_camera_is_read(tmp_path: Path) -> None:
    (tmp_path / "camera.json").write_text(camera_json())
    assert fs.read_camera(tmp_path / "camera.json") == CAMERA


def test_a_camera_of_the_command_is_that_of_the_functions(tmp_path: Path) -> None:
    """Its numbers side by side, with the size of the images or without."""
    image, depth = content(1)
    numbers, path = vars(CAMERA), tmp_path / "flat.json"
    path.write_text(json.dumps(numbers))
    assert fs.read_camera(path) == CAMERA
    np.testing.assert_array_equal(fog(image, depth, 0.02, path), fog(image, depth, 0.02, CAMERA))
    path.write_text(json.dumps({name: numbers[name] for name in ("fx", "fy", "u0", "v0")}))
    np.testing.assert_array_equal(fs.distance(depth, path), fs.distance(depth, CAMERA))
    with pytest.raises(FoggyError, match=r"flat\.json: does not say how large its images are"):
        fs.read_camera(path)
    path.write_text(json.dumps(numbers | {"resx": 41}))
    with pytest.raises(ValueError, match="camera: of 41 x 24 pixels, but depth has 40 x 24"):
        fog(image, depth, 0.02, path)
    with pytest.raises(ValueError, match="camera: dict, expected Camera or a file"):
        fog(image, depth, 0.02, numbers)


def test_depth_is_read_in_the_formats_of_the_command(tmp_path: Path) -> None:
    metres = np.array([[1.5, 0.0], [2.0, 300.0]])
    np.save(tmp_path / "metres.npy", metres)
    (tmp_path / "centimetres.png").write_bytes(encode_png((metres * 100).astype(np.uint16)))
    np.testing.assert_array_equal(fs.read_depth(tmp_path / "metres.npy"), metres)
    found = fs.read_depth(tmp_path / "centimetres.png", scale=0.01)
    np.testing.assert_allclose(found, np.where(metres == 0, np.nan, metres))
    with pytest.raises(
        FoggyError, match=r"unit it does not tell. Give metres per unit by read_depth\(path, scale\), e\.g\. 0\.001"
    ):
        fs.read_depth(tmp_path / "centimetres.png")
    view = np.zeros((2, 2, 3), np.uint8)
    ray = fog(view, metres, 0.01, depth_is="ray", airlight=(200, 200, 200))
    np.testing.assert_array_equal(
        fog(view, tmp_path / "metres.npy", 0.01, depth_is="ray", airlight=(200, 200, 200)), ray
    )
    with pytest.raises(ValueError, match="negative or not a number"):
        fog(view, found, 0.01, depth_is="ray")
