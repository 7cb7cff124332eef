"""foggy fog on frames of any origin: formats of depth, cameras, missing depth, names, and every kind of bad input."""

import io
import json
import shutil
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from fog_frames import tree
from recipe_frames import FX, PLAIN, SIZE, carla_code, exr, npy, png16, rgba, street, tiff

from foggy_synscapes.cli import main
from foggy_synscapes.io.atomic import write_bytes, write_text
from foggy_synscapes.io.images import encode_png, read_rgb
from foggy_synscapes.io.pictures import encode_jpeg

BETA = ["--beta", "0.02", "--out", "out"]
PLACE = ["--rgb", "rgb", "--depth", "depth", "--camera", "camera.json"]
IMAGE, SKY = street()
DEPTH = np.minimum(SKY, 500.0)
FOGGY = "out/beta_0.02/foggy_img/a_beta_0.02.png"


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with an image, and a camera for it."""
    monkeypatch.chdir(tmp_path)
    write_bytes(tmp_path / "rgb/a.png", encode_png(IMAGE))
    write_text(tmp_path / "camera.json", json.dumps(PLAIN))
    (tmp_path / "depth").mkdir()
    return tmp_path


def fog(*options: str, place: list[str] = PLACE) -> int:
    return main(["fog", *place, *options, *BETA])


def failure(capsys: pytest.CaptureFixture, status: int, expected: int = 1) -> str:
    error = capsys.readouterr().err
    assert status == expected, error
    assert "Traceback" not in error
    return error


def npz(**arrays: Any) -> bytes:
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)
    return buffer.getvalue()


def mat73(values: np.ndarray) -> bytes:
    buffer = io.BytesIO()
    with h5py.File(buffer, "w") as file:
        file["z"] = values.T
    return buffer.getvalue()


def mat(values: np.ndarray) -> bytes:
    buffer = io.BytesIO()
    pytest.importorskip("scipy.io", reason="MATLAB files need SciPy").savemat(buffer, {"z": values})
    return buffer.getvalue()


@pytest.mark.parametrize("name", ["exr", "npy", "npz", "tif", "mat", "mat73"])
def test_the_same_depth_gives_the_same_fog_whatever_its_format(here: Path, name: str) -> None:
    values = DEPTH.astype(np.float32)
    contents = {
        "exr": lambda: exr({"Z": values}), "npy": lambda: npy(values[None]), "npz": lambda: npz(depth=values),
        "mat": lambda: mat(values), "mat73": lambda: mat73(values),
    }  # fmt: skip
    if name == "tif":
        tiff(values, here / "depth/a.tif")
    else:
        write_bytes(here / f"depth/a.{name[:3]}", contents[name]())
    assert fog() == 0
    (here / "depth/a.exr").write_bytes(exr({"Z": values}))
    other = ["--rgb", "rgb/*.png", "--depth", "depth/*.exr", "--intrinsics", f"{FX},{FX},20,12"]
    assert main(["fog", *other, "--beta", "0.02", "--out", "other"]) == 0
    found, expected = (
        {path: data for path, data in tree(here / out).items() if "foggy" in path} for out in ("out", "other")
    )
    assert found == expected
    assert len(found) == 1


@pytest.mark.parametrize("scale", ["0.001", "1/256", "0.01"])
def test_whole_numbers_are_depth_by_their_scale(here: Path, scale: str) -> None:
    metres = np.minimum(DEPTH, 60.0)
    unit = 1 / 256 if scale == "1/256" else float(scale)
    write_bytes(here / "depth/a.png", png16(metres, unit))
    write_bytes(here / "exact/a.npy", npy(np.round(metres / unit) * unit))
    assert fog("--depth-scale", scale) == 0
    found = read_rgb(here / FOGGY)
    assert (
        main(["fog", "--rgb", "rgb", "--depth", "exact", "--camera", "camera.json", "--beta", "0.02", "--out", "two"])
        == 0
    )
    np.testing.assert_array_equal(found, read_rgb(here / FOGGY.replace("out", "two", 1)))


CAMERAS: dict[str, str] = {
    "plain": json.dumps({"fx": FX, "fy": FX, "cx": 20.0, "cy": 12.0, "width": 40, "height": 24}),
    "matrix": json.dumps({"K": [[FX, 0, 20], [0, FX, 12], [0, 0, 1]]}),
    "matrix in a row": json.dumps({"K": [FX, 0, 20, 0, FX, 12, 0, 0, 1]}),
    "cityscapes": json.dumps({"intrinsic": {"fx": FX, "fy": FX, "u0": 20, "v0": 12}, "extrinsic": {"baseline": 0.2}}),
    "synscapes": json.dumps({"camera": {"intrinsic": PLAIN | {"resx": 40, "resy": 24}, "extrinsic": {}}}),
    "object": f"P0: 1 0 0 0 0 1 0 0 0 0 1 0\nP2: {FX} 0 20 5 0 {FX} 12 0 0 0 1 0\nR0_rect: 1 0 0 0 1 0 0 0 1\n",
    "matrix of text": f"{FX} 0 20\n0 {FX} 12\n0 0 1\n",
}


@pytest.mark.parametrize("kind", CAMERAS)
def test_camera_files_of_any_dataset_are_the_same_camera(here: Path, kind: str) -> None:
    write_bytes(here / "depth/a.npy", npy(DEPTH))
    write_text(here / "calib/a.txt", CAMERAS[kind])
    assert fog(place=["--rgb", "rgb", "--depth", "depth", "--camera", "calib"]) == 0
    found = read_rgb(here / FOGGY)
    assert main(["fog", *PLACE, "--beta", "0.02", "--out", "two"]) == 0
    np.testing.assert_array_equal(found, read_rgb(here / FOGGY.replace("out", "two", 1)))


def test_each_folder_has_its_own_camera(here: Path) -> None:
    for number, name in enumerate(("left", "right")):
        write_bytes(here / f"cams/{name}/rgb/a.png", encode_png(IMAGE))
        write_bytes(here / f"cams/{name}/z/a.npy", npy(DEPTH))
        write_text(here / f"cams/{name}.json", json.dumps(PLAIN | {"fx": FX / (1 + number)}))
    place = ["--rgb", "cams/*/rgb/*.png", "--depth", "cams/*/z/*.npy", "--camera", "cams/*.json"]
    assert fog("--jobs", "2", place=place) == 0
    left, right = (read_rgb(here / f"out/beta_0.02/foggy_img/{name}/rgb/a_beta_0.02.png") for name in ("left", "right"))
    assert (left != right).any()


HOLES = DEPTH.copy()
HOLES[15:17, 3:8], HOLES[18, 5], HOLES[18, 6] = 0, np.nan, -1


def test_missing_depth_is_refused_with_its_count_unless_it_has_an_answer(here: Path, capsys) -> None:
    write_bytes(here / "depth/a.npy", npy(HOLES))
    error = failure(capsys, fog())
    assert "depth/a.npy: 12 of 960 pixels (1.2%) have no depth: 0, negative or not a number." in error
    assert "--missing far" in error
    shutil.rmtree(here / "out", ignore_errors=True)
    assert fog("--missing", "far") == 0
    assert "12 of 960 pixels (1.2%) have no depth, and are taken for infinitely far" in capsys.readouterr().err
    assert (read_rgb(here / FOGGY)[15:17, 3:8] == (251, 255, 249)).all()
    assert fog("--missing", "complete") == 1  # not into the same folder
    write_bytes(here / "whole/a.npy", npy(DEPTH))
    for depth, out in (("depth", "filled"), ("whole", "whole_fog")):
        call = ["fog", "--rgb", "rgb", "--depth", depth, "--camera", "camera.json", "--missing", "complete"]
        assert main([*call, "--beta", "0.02", "--out", out]) == 0
    filled, whole = (read_rgb(here / FOGGY.replace("out", out, 1)).astype(int) for out in ("filled", "whole_fog"))
    same = np.isfinite(HOLES) & (HOLES > 0)
    np.testing.assert_array_equal(filled[same], whole[same])
    assert np.abs(filled - whole).mean() < 1


def test_visibility_is_printed_and_is_another_name_of_beta(here: Path, capsys) -> None:
    write_bytes(here / "depth/a.npy", npy(DEPTH))
    assert main(["fog", *PLACE, "--visibility", "150", "--out", "out"]) == 0
    assert "beta 0.01997 / m is a visibility of 150 m" in capsys.readouterr().out
    assert main(["fog", *PLACE, "--beta", "0.01997", "--out", "two"]) == 0
    assert [data for name, data in tree(here / "out").items() if name.endswith(".png")] == [
        data for name, data in tree(here / "two").items() if name.endswith(".png")
    ]


@pytest.mark.parametrize(
    ("beta", "said"),
    [
        ("0.2", "beta 0.2 1/m is a visibility of 15 m; did you mean 0.02, 150 m?"),
        ("5", "depth/a.npy: nothing is nearer than 12.3 m, but the visibility at beta 5.0 / m is 0.599 m"),
    ],
)
def test_odd_betas_are_asked_back(here: Path, capsys, beta: str, said: str) -> None:
    write_bytes(here / "depth/a.npy", npy(DEPTH))
    assert main(["fog", *PLACE, "--beta", beta, "--out", "out"]) == 0
    assert said in capsys.readouterr().err


def test_metres_of_visibility_are_no_slip_of_a_digit(here: Path, capsys) -> None:
    write_bytes(here / "depth/a.npy", npy(DEPTH))
    assert main(["fog", *PLACE, "--visibility", "20", "--out", "out"]) == 0
    assert "did you mean" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (PLACE, "give --beta or --visibility; --out"),
        ([*PLACE, "--out", "out"], "give --beta or --visibility"),
        ([*PLACE, "--visibility", "150"], "give --out"),
        (["--beta", "0.1", "--out", "out"], "give --synscapes ROOT, or --rgb DIR"),
        ([], "give --rgb, --depth and --camera (or --synscapes, --layout, or --shard); --beta or --visibility; --out"),
    ],
)
def test_only_what_is_missing_of_a_call_is_named(capsys, options: list[str], message: str) -> None:
    error = failure(capsys, main(["fog", *options]), expected=2)
    assert message in error
    assert error.rstrip().endswith(message) or options[:1] == ["--beta"]


def test_a_missing_file_of_depth_is_named_as_the_others_end(here: Path, capsys) -> None:
    write_bytes(here / "depth/a.npy", npy(DEPTH))
    write_bytes(here / "rgb/b.png", encode_png(IMAGE))
    error = failure(capsys, fog())
    assert "depth/b.npy: missing" in error
    assert "stopped at this one of 2 frames. Correct it and give the same command again; --keep-going" in error


@pytest.mark.parametrize("factor", [100, 1000, 0.001])
def test_metres_that_are_none_are_warned_about(here: Path, capsys, factor: float) -> None:
    write_bytes(here / "depth/a.npy", npy(DEPTH * factor))
    assert fog() == 0
    assert "a.npy: its median depth is" in capsys.readouterr().err


def test_grey_and_opaque_images_are_read_and_transparent_ones_refused(here: Path, capsys) -> None:
    write_bytes(here / "depth/a.npy", npy(DEPTH))
    (here / "rgb/a.png").write_bytes(encode_png(IMAGE[..., 0].copy()))
    assert fog() == 0
    grey = read_rgb(here / FOGGY)
    assert (grey[..., 0] == grey[..., 1]).all()
    (here / "rgb/a.png").write_bytes(rgba(IMAGE))
    assert fog() == 0
    (here / "rgb/a.png").write_bytes(rgba(IMAGE, 254))
    assert "rgb/a.png: 960 pixels are transparent" in failure(capsys, fog())


def bad(here: Path, kind: str) -> list[str]:
    """Spoil one thing, and return the options that go with it."""
    disparity = ["--depth-is", "disparity", "--depth-scale", "1/256"]
    stored = png16(FX * 0.5 / DEPTH, 1 / 256)
    files: dict[str, tuple[str, bytes, list[str]]] = {
        "disparity of another size": ("a.png", png16(np.ones((12, 20)), 1), [*disparity, "--baseline", "1"]),
        "camera without baseline": ("a.png", stored, disparity),
        "8-bit disparity": ("a.png", encode_png(np.ones(SIZE, np.uint8)), [*disparity, "--baseline", "1"]),
        "all-invalid disparity": ("a.png", encode_png(np.zeros(SIZE, np.uint16)), [*disparity, "--baseline", "1"]),
        "no unit": ("a.png", png16(DEPTH, 0.01), []),
        "picture of depth": ("a.png", encode_png(carla_code(DEPTH)), []),
        "not CARLA's": ("a.png", png16(DEPTH, 0.01), ["--depth-code", "rgb24", "--depth-scale", "0.01"]),
        "several arrays": ("a.npz", npz(z=DEPTH, t=DEPTH), []),
        "no such array": ("a.npz", npz(z=DEPTH), ["--depth-channel", "depth"]),
        "no channel Z": ("a.exr", exr({"A": DEPTH.astype(np.float32), "B": DEPTH.astype(np.float32)}), []),
        "turned": ("a.npy", npy(DEPTH.T), []),
        "cut off": ("a.npy", npy(DEPTH)[:-5], []),
        "claims too much": ("a.npy", npy(DEPTH).replace(b"(24, 40)", b"(2400,4)", 1), []),
        "words": ("a.npy", npy(np.array([["near"]])), []),
        "complex": ("a.npy", npy(DEPTH + 1j), []),
        "far camera": ("a.npy", npy(DEPTH), ["--camera", "far.json"]),
        "no camera": ("a.npy", npy(DEPTH), ["--camera", "none.json"]),
        "other image's camera": ("a.npy", npy(DEPTH), ["--camera", "other.json"]),
        "few known": ("a.npy", npy(np.where(np.arange(960).reshape(SIZE) < 15, DEPTH, 0)), ["--missing", "complete"]),
    }  # fmt: skip
    name, data, options = files[kind]
    write_bytes(here / "depth" / name, data)
    write_text(here / "far.json", json.dumps(PLAIN | {"fx": "44"}))
    write_text(here / "none.json", json.dumps({"fx": 44.0}))
    write_text(here / "other.json", json.dumps(PLAIN | {"width": 80, "height": 48}))
    return options


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        ("disparity of another size", "depth/a.png: 20 x 12 pixels, but rgb/a.png has 40 x 24"),
        ("camera without baseline", "camera.json: has no baseline"),
        ("8-bit disparity", "depth/a.png: 8-bit grey, expected 16-bit grey. An 8-bit copy has lost its precision"),
        ("all-invalid disparity", "depth/a.png: no pixel has depth"),
        ("no unit", "depth/a.png: holds uint16, whose unit it does not tell. Give metres per unit by --depth-scale"),
        (
            "picture of depth",
            "depth/a.png: holds uint8 (24, 40, 3), expected one number for each pixel; is it depth in",
        ),
        ("not CARLA's", "depth/a.png: holds uint16 (24, 40), expected depth in the three colours of 8 bits"),
        ("several arrays", "depth/a.npz: 2 arrays (z, t). Name one by --depth-channel"),
        ("no such array", "depth/a.npz: no array depth; there are z"),
        ("no channel Z", "depth/a.exr: no channel Z; name the one of depth by --depth-channel, out of A, B"),
        (
            "turned",
            "depth/a.npy: 24 x 40 pixels, but rgb/a.png has 40 x 24. Are they of the same frame and resolution? Is",
        ),
        ("cut off", "depth/a.npy: not a readable NumPy array"),
        ("claims too much", "depth/a.npy: not a readable NumPy array: its header claims float64 (2400, 4)"),
        ("words", "depth/a.npy: <U4 (1, 1), expected one number for each pixel"),
        ("complex", "depth/a.npy: complex128 (24, 40), expected one number for each pixel"),
        ("far camera", "far.json: fx: not a readable number: '44', expected a finite number"),
        ("no camera", "none.json: fy, u0, v0 missing. Read are camera files of Synscapes, Cityscapes and KITTI"),
        ("other image's camera", "other.json: its camera has 80 x 48 pixels, but the image has 40 x 24"),
        ("few known", "depth/a.npy: 15 of 960 pixels have depth, and none of"),
    ],
)
def test_bad_input_is_named(here: Path, capsys, kind: str, message: str) -> None:
    assert message in failure(capsys, fog(*bad(here, kind)))
    assert not list((here / "out").rglob("*.png"))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--rgb", "rgb", "--depth", "depth"], "give --synscapes ROOT, or --rgb DIR, --depth DIR and --camera FILE"),
        ([*PLACE, "--fov", "90"], "--camera, --camera-in-depth, --fov and --intrinsics: give one of them"),
        ([*PLACE[:4], "--fov", "180"], "--fov 180.0: expected degrees between 0 and 180"),
        ([*PLACE[:4], "--intrinsics", "1,2"], "--intrinsics 1,2: expected FX,FY,U0,V0"),
        ([*PLACE, "--depth-scale", "-1"], "--depth-scale -1: expected metres per unit above 0"),
        ([*PLACE, "--depth-scale", "1/0"], "--depth-scale 1/0: expected metres per unit"),
        ([*PLACE, "--quality", "90"], "--quality: goes with --format jpg"),
        ([*PLACE, "--visibility", "0"], "--visibility 0: expected metres above 0"),
        (
            ["--rgb", "rgb/*.png", "--depth", "depth/a.npy", "--fov", "9"],
            "depth/a.npy: no such folder or file (--depth)",
        ),
        (["--rgb", "rgb/*.png", "--depth", "*/*.npy", "--fov", "9"], "has 2 wildcards, and --rgb 1"),
        (["--rgb", "nowhere", "--depth", "depth", "--fov", "9"], "nowhere: no such folder or file (--rgb)"),
        (["--layout", "kitti", "--root", ".", "--refine", "guided"], "--refine: --layout kitti takes no such option"),
        (
            ["--layout", "carla", "--root", ".", "--depth-scale", "1"],
            "--depth-scale: --layout carla names frames, depth",
        ),
        (["--layout", "vkitti", "--root", "."], "no SceneNN/VARIATION/frames"),
        (["--synscapes", ".", "--missing", "far"], "--missing: goes with --rgb"),
        (
            ["--rgb", "rgb", "--transmittance-map", "depth", "--beta", "1"],
            "--transmittance-map: goes with --rgb and the",
        ),
    ],
)
def test_a_wrong_call_ends_with_status_2(here: Path, capsys, options: list[str], message: str) -> None:
    assert message in failure(capsys, main(["fog", *options, *BETA]), expected=2)
    assert not (here / "out").exists()


def test_a_folder_without_depth_names_the_formats_that_are_read(here: Path, capsys) -> None:
    write_bytes(here / "depth/b.pfm", b"")
    error = failure(capsys, fog())
    assert "depth: holds depth of none of 1 images; of rgb/a.png it would be depth/a.exr. Read are .exr (" in error
    assert ".npz (NumPy)" in error
    assert failure(capsys, main(["fog", "--layout", "kitti", "--root", ".", *BETA])).startswith(
        "foggy fog: .: no depth"
    )


def test_an_interrupted_run_goes_on_to_the_same_bytes(here: Path) -> None:
    for name in "abc":
        write_bytes(here / f"rgb/{name}.jpg", encode_jpeg(IMAGE))
        write_bytes(here / f"depth/{name}.npy", npy(HOLES))
    (here / "rgb/a.png").unlink()
    assert fog("--missing", "complete", "--format", "jpg") == 0
    whole = tree(here / "out")
    (here / "out/beta_0.02/foggy_img/b_beta_0.02.jpg").unlink()
    (here / "out/beta_0.02/foggy_img/.c_beta_0.02.jpg.x.part").write_bytes(b"half")
    assert fog("--missing", "complete", "--format", "jpg") == 0
    assert tree(here / "out") == whole


def test_two_depths_of_one_image_are_asked_back(here: Path, capsys) -> None:
    write_bytes(here / "depth/a.npy", npy(DEPTH))
    write_bytes(here / "depth/a.exr", exr({"Z": DEPTH.astype(np.float32)}))
    assert "depth/a.exr and depth/a.npy: which is it?" in failure(capsys, fog())


@pytest.mark.parametrize("values", [np.full(SIZE, 0.5), np.full(SIZE, 128, np.uint8), np.full(SIZE, 32896, np.uint16)])
def test_maps_of_transmittance_have_any_depth_of_bits(here: Path, values: np.ndarray) -> None:
    whole = {"uint8": 255, "uint16": 65535}.get(values.dtype.name, 1)
    name, data = ("a.npy", npy(values)) if whole == 1 else ("a.png", encode_png(values))
    write_bytes(here / "t" / name, data)
    assert main(["fog", "--rgb", "rgb", "--transmittance-map", "t", *BETA]) == 0
    t = values[..., None] / whole
    light = np.array([251, 255, 249])
    np.testing.assert_array_equal(
        read_rgb(here / FOGGY), np.floor(255 * (t * (IMAGE / 255) + (1 - t) * (light / 255)) + 0.5)
    )


def test_a_map_that_is_none_is_refused(here: Path, capsys) -> None:
    write_bytes(here / "t/a.npy", npy(DEPTH))
    status = main(["fog", "--rgb", "rgb", "--transmittance-map", "t", *BETA])
    assert "t/a.npy: holds float64 (24, 40), not all of it from 0 to 1" in failure(capsys, status)
