"""foggy fog alone: folders in, folders out, every kind of bad input, interruption and resumption."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from fog_frames import CAMERA, SIZE, camera_json, content, tree, write_frame, write_frames

from foggy_synscapes.camera import Camera
from foggy_synscapes.cli import main
from foggy_synscapes.fog.airlight import estimate
from foggy_synscapes.fog.geometry import rays
from foggy_synscapes.fog.optics import foggy_images, transmittance_images
from foggy_synscapes.io.images import encode_depth, encode_png, read_ids, read_rgb
from foggy_synscapes.io.tables import read_csv

FOGGY = [sys.executable, "-c", "from foggy_synscapes.cli import main; raise SystemExit(main())"]


@pytest.fixture
def root(tmp_path: Path) -> Path:
    return write_frames(tmp_path / "synscapes", 3)


def fog(root: Path, out: Path, *options: str) -> int:
    betas = [] if any(option.startswith("--beta") for option in options) else ["--beta", "0.02"]
    return main(["fog", "--synscapes", str(root), "--out", str(out), *betas, *options])


def failure(capsys: pytest.CaptureFixture, status: int, expected: int = 1) -> str:
    captured = capsys.readouterr()
    assert status == expected, captured
    assert "Traceback" not in captured.err
    return captured.err


def images(out: Path) -> list[str]:
    return sorted(path.name for path in out.rglob("*.png") if not path.name.startswith("."))


@pytest.mark.parametrize("geometry", ["paper", "exact"])
def test_folders_hold_fog_transmittance_and_airlight(root: Path, tmp_path: Path, geometry: str, capsys) -> None:
    out = tmp_path / "out"
    options = ["--beta", "0.005", "--beta", "0.060", "--geometry", geometry, "--transmittance"]
    assert fog(root, out, *options) == 0
    assert re.search(r"3 frames, 2 betas, 12 images made, 0 kept, .* images/s, .* MB", capsys.readouterr().out)
    table = read_csv(out / "airlight.csv")
    assert list(table[0]) == ["id", "red", "green", "blue", "row", "column"]
    assert [row["id"] for row in table] == ["1", "2", "3"]
    lines = rays(CAMERA, geometry)
    for frame, row in zip((1, 2, 3), table, strict=True):
        image, depth = content(frame)
        light = estimate(image)
        assert tuple(map(int, list(row.values())[1:])) == (*light.levels, light.row, light.column)
        foggy = foggy_images(image, depth, lines, light.levels, [0.005, 0.06])
        maps = transmittance_images(depth, lines, [0.005, 0.06])
        for beta, one, t in zip(("0.005", "0.06"), foggy, maps, strict=True):
            name = f"{frame:05d}_beta_{beta}.png"
            np.testing.assert_array_equal(read_rgb(out / f"beta_{beta}/foggy_img/{name}"), one)
            np.testing.assert_array_equal(read_ids(out / f"beta_{beta}/transmittance/{name}"), t)
    assert len(images(out)) == 12


def test_any_number_of_processes_writes_the_same_bytes(root: Path, tmp_path: Path) -> None:
    assert fog(root, tmp_path / "one") == 0
    assert fog(root, tmp_path / "two", "--jobs", "2") == 0
    assert tree(tmp_path / "one") == tree(tmp_path / "two")


def test_ids_choose_frames_and_the_table_grows(root: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert fog(root, out, "--ids", "3") == 0
    assert images(out) == ["00003_beta_0.02.png"]
    assert fog(root, out, "--ids", "1-2") == 0
    assert [row["id"] for row in read_csv(out / "airlight.csv")] == ["1", "2", "3"]


def test_plain_folders_with_one_camera(tmp_path: Path) -> None:
    rgb, depth = tmp_path / "pictures", tmp_path / "depths"
    rgb.mkdir()
    depth.mkdir()
    (tmp_path / "camera.json").write_text(camera_json())
    for name, frame in (("street", 1), ("12", 2)):
        image, metres = content(frame)
        (rgb / f"{name}.png").write_bytes(encode_png(image))
        (depth / f"{name}.exr").write_bytes(encode_depth(metres))
    paths = ["--rgb", str(rgb), "--depth", str(depth), "--camera", str(tmp_path / "camera.json")]
    assert main(["fog", *paths, "--beta", "0.02", "--out", str(tmp_path / "out")]) == 0
    assert images(tmp_path / "out") == ["12_beta_0.02.png", "street_beta_0.02.png"]
    assert [row["id"] for row in read_csv(tmp_path / "out" / "airlight.csv")] == ["12", "street"]
    # The pixels do not depend on where a frame came from.
    assert fog(write_frames(tmp_path / "synscapes", 2), tmp_path / "other") == 0
    np.testing.assert_array_equal(
        read_rgb(tmp_path / "out/beta_0.02/foggy_img/12_beta_0.02.png"),
        read_rgb(tmp_path / "other/beta_0.02/foggy_img/00002_beta_0.02.png"),
    )


def test_two_images_that_would_share_a_file_name_are_refused(tmp_path: Path, capsys) -> None:
    for name in ("7.png", "7.PNG"):
        (tmp_path / name).write_bytes(encode_png(content(1)[0]))
    (tmp_path / "camera.json").write_text(camera_json())
    status = main(["fog", "--rgb", str(tmp_path), "--depth", str(tmp_path), "--camera", str(tmp_path / "camera.json"),
                   "--beta", "0.02", "--out", str(tmp_path / "out")])  # fmt: skip
    assert "would give the same file names" in failure(capsys, status)


def test_beta_zero_is_the_clear_image(root: Path, tmp_path: Path) -> None:
    assert fog(root, tmp_path / "out", "--beta", "0", "--transmittance") == 0
    np.testing.assert_array_equal(read_rgb(tmp_path / "out/beta_0/foggy_img/00002_beta_0.png"), content(2)[0])
    assert (read_ids(tmp_path / "out/beta_0/transmittance/00002_beta_0.png") == 255).all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--beta=-0.005"], "-0.005 is not a positive finite number"),
        (["--beta", "nan"], "not a positive finite number"),
        (["--beta", "inf"], "not a positive finite number"),
        (["--beta", "thick"], "'thick' is not a number"),
        (["--beta", "0.01", "--beta", "0.010"], "--beta 0.01 and --beta 0.010 name the same folder beta_0.01"),
        (["--beta", "0.01", "--beta", "1e-2"], "name the same folder beta_0.01"),
        (["--ids", "5-3"], "the range 5-3 is empty"),
        (["--ids", "all"], "'all' is no number or range"),
        (["--jobs", "0"], "--jobs 0: expected 1 or more"),
        (["--shard", "0000"], "is not for jobs of the pipeline"),
        (["--rgb", "x"], "give --synscapes ROOT, or --rgb DIR"),
    ],
)
def test_a_wrong_call_ends_with_status_2(root: Path, tmp_path: Path, capsys, options: list[str], message: str) -> None:
    assert message in failure(capsys, fog(root, tmp_path / "out", *options), expected=2)
    assert not (tmp_path / "out").exists()


def test_a_folder_that_is_not_there_is_named(tmp_path: Path, capsys) -> None:
    assert "nowhere/img/rgb: no such folder" in failure(capsys, fog(tmp_path / "nowhere", tmp_path / "out"), 2)
    (tmp_path / "empty/img/rgb").mkdir(parents=True)
    assert "holds no image" in failure(capsys, fog(tmp_path / "empty", tmp_path / "out"))


def spoil(root: Path, what: str) -> str:
    """Break frame 2 and return what the message has to say."""
    rgb, depth, meta = (root / path for path in ("img/rgb/2.png", "img/depth/2.exr", "meta/2.json"))
    image, metres = content(2)
    files = {
        "cut rgb": (rgb, rgb.read_bytes()[:-20], r"img/rgb/2\.png: cut off"),
        "changed rgb": (rgb, rgb.read_bytes()[:80] + b"?" + rgb.read_bytes()[81:], r"img/rgb/2\.png: damaged"),
        "grey rgb": (rgb, encode_png(image[..., 0]), r"img/rgb/2\.png: 8-bit grey, expected 8-bit RGB"),
        "cut depth": (depth, depth.read_bytes()[:700], r"img/depth/2\.exr: not a readable EXR"),
        "small depth": (depth, encode_depth(metres[1:]), r"img/depth/2\.exr: 40 x 23 pixels, but .*2\.png has 40 x 24"),
        "one row": (depth, encode_depth(metres[:1]), r"img/depth/2\.exr: 40 x 1 pixels"),
        "negative": (
            depth,
            encode_depth(np.where(metres == 8000, -1, metres).astype("f4")),
            r"2\.exr: depth: 640 values are negative .* the first is -1\.0 at row 0, column 0",
        ),
        "nan": (depth, encode_depth(np.where(metres == 8000, np.nan, metres).astype("f4")), "not a number"),
        "meta": (meta, b"{}", r"meta/2\.json: camera\.intrinsic\.fx missing"),
        "meta without end": (
            meta,
            camera_json().replace(": 40,", ": Infinity,").encode(),
            r"2\.json: .*inf, expected a finite",
        ),
        "meta of half a pixel": (meta, camera_json().replace(": 40,", ": 40.5,").encode(), r"2\.json: .*resx is 40\.5"),
        "far meta": (meta, camera_json().replace("44.0", "1e200").encode(), r"2\.json: .*fx is 1e\+200"),
        "size": (meta, camera_json(Camera(44, 45, 20, 11, 41, 24)).encode(), r"2\.json: its camera has 41 x 24 pixels"),
    }
    if what in ("rgb", "depth", "meta file"):
        path = {"rgb": rgb, "depth": depth, "meta file": meta}[what]
        path.unlink()
        return rf"{path.name}: missing"
    if what == "no Z":
        OpenEXR.File({}, {"Y": metres}).write(str(depth))
        return r"img/depth/2\.exr: channel Y, expected 1 named Z"
    path, data, message = files[what]
    path.write_bytes(data)
    return message


@pytest.mark.parametrize(
    "what",
    ["rgb", "depth", "meta file", "cut rgb", "changed rgb", "grey rgb", "cut depth", "small depth", "one row",
     "negative", "nan", "meta", "meta without end", "meta of half a pixel", "far meta", "size", "no Z"],
)  # fmt: skip
def test_a_broken_frame_is_named_and_the_others_are_finished(root: Path, tmp_path: Path, capsys, what: str) -> None:
    message = spoil(root, what)
    out = tmp_path / "out"
    error = failure(capsys, fog(root, out, "--keep-going", "--ids", "1-3"))
    assert re.search(message, error), error
    assert "1 of 3 frames broken" in error
    assert images(out) == ["00001_beta_0.02.png", "00003_beta_0.02.png"]
    assert [row["id"] for row in read_csv(out / "airlight.csv")] == ["1", "3"]
    assert not list(out.rglob(".*"))


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_three_broken_of_many_are_all_named(tmp_path: Path, capsys, jobs: str) -> None:
    root = write_frames(tmp_path / "synscapes", 30)
    for frame in (7, 8, 23):
        (root / f"img/depth/{frame}.exr").write_bytes(b"broken")
    out = tmp_path / "out"
    error = failure(capsys, fog(root, out, "--keep-going", "--jobs", jobs))
    assert [f"img/depth/{frame}.exr" in error for frame in (7, 8, 9, 23)] == [True, True, False, True]
    assert "3 of 30 frames broken" in error
    assert len(images(out)) == 27
    # Mended, the same command makes the rest only.
    for frame in (7, 8, 23):
        write_frame(root, frame)
    assert fog(root, out, "--keep-going", "--jobs", jobs) == 0
    assert "3 images made, 27 kept" in capsys.readouterr().out
    assert len(images(out)) == 30


def test_without_keep_going_the_first_broken_frame_stops_the_run(root: Path, tmp_path: Path, capsys) -> None:
    spoil(root, "cut rgb")
    error = failure(capsys, fog(root, tmp_path / "out"))
    assert "2.png: cut off" in error
    assert "--keep-going" in error
    assert images(tmp_path / "out") == ["00001_beta_0.02.png"]


def test_a_broken_camera_for_all_is_said_once(root: Path, tmp_path: Path, capsys) -> None:
    (tmp_path / "camera.json").write_text("{}")
    error = failure(capsys, fog(root, tmp_path / "out", "--camera", str(tmp_path / "camera.json"), "--keep-going"))
    assert error.count("camera.json") == 1


def test_a_camera_that_no_depth_file_holds_is_named(root: Path, tmp_path: Path, capsys) -> None:
    error = failure(capsys, fog(root, tmp_path / "out", "--camera-in-depth"))
    assert "img/depth/1.exr: its header has no camera:zoom and no image:window" in error
    status = fog(root, tmp_path / "out", "--camera-in-depth", "--camera", str(root / "meta/1.json"))
    assert "give one of them" in failure(capsys, status, expected=2)


def test_missing_depth_values_and_black_images_are_warned_about(root: Path, tmp_path: Path, capsys) -> None:
    image, depth = content(1)
    depth[20, :7] = 0
    (root / "img/depth/1.exr").write_bytes(encode_depth(depth))
    (root / "img/rgb/2.png").write_bytes(encode_png(np.zeros_like(image)))
    assert fog(root, tmp_path / "out") == 0
    error = capsys.readouterr().err
    assert "img/depth/1.exr: 7 pixels at distance 0, which usually means missing depth" in error
    assert "img/rgb/2.png: its airlight is black" in error
    foggy = read_rgb(tmp_path / "out/beta_0.02/foggy_img/00001_beta_0.02.png")
    np.testing.assert_array_equal(foggy[20, :7], image[20, :7])


@pytest.mark.parametrize("answer", ["keep", "drop", "grey"])
def test_blue_airlight_is_reported_and_answered_as_asked(tmp_path: Path, capsys, answer: str) -> None:
    root, out = write_frames(tmp_path / "synscapes", 6), tmp_path / "out"
    assert fog(root, out, "--blue-airlight", answer) == 0
    said = {"keep": "used as it is", "drop": "left out", "grey": "made grey"}[answer]
    assert re.search(f"blue atmospheric light in 1 frames, .*{said}.*: 5\n", capsys.readouterr().out)
    path = out / "beta_0.02/foggy_img/00005_beta_0.02.png"
    row = read_csv(out / "airlight.csv")[4]
    if answer == "drop":
        assert not path.exists()
        assert len(images(out)) == 5
        return
    light = {"keep": [150, 190, 240], "grey": [184, 184, 184]}[answer]
    assert read_rgb(path)[0, 0].tolist() == light
    assert [int(row[name]) for name in ("red", "green", "blue")] == light


def test_what_is_finished_is_kept_and_what_is_not_right_is_made_again(root: Path, tmp_path: Path, capsys) -> None:
    out, again = tmp_path / "out", ["--beta", "0.01", "--beta", "0.02"]
    assert fog(root, out, *again) == 0
    whole = tree(out)
    assert fog(root, out, *again) == 0
    assert "0 images made, 6 kept" in capsys.readouterr().out
    # Gone, cut off, and of an image of which only the time changed.
    (out / "beta_0.01/foggy_img/00001_beta_0.01.png").unlink()
    cut = out / "beta_0.02/foggy_img/00002_beta_0.02.png"
    cut.write_bytes(cut.read_bytes()[:99])
    (out / "airlight.csv").unlink()
    later = time.time() + 5
    os.utime(root / "img/rgb/3.png", (later, later))
    assert fog(root, out, *again) == 0
    assert "2 images made, 4 kept" in capsys.readouterr().out
    assert tree(out) == whole  # the table of airlight too


def test_a_changed_image_gets_new_fog_and_a_new_airlight(root: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert fog(root, out) == 0
    (root / "img/rgb/1.png").write_bytes(encode_png(np.full((*SIZE, 3), 77, np.uint8)))
    later = time.time() + 5
    os.utime(root / "img/rgb/1.png", (later, later))
    assert fog(root, out) == 0
    assert list(read_csv(out / "airlight.csv")[0].values()) == ["1", "77", "77", "77", "0", "0"]


def test_a_folder_made_with_other_settings_is_refused(root: Path, tmp_path: Path, capsys) -> None:
    assert fog(root, tmp_path / "out") == 0
    error = failure(capsys, fog(root, tmp_path / "out", "--geometry", "exact"))
    assert "settings.json" in error
    assert "Choose another --out" in error


@pytest.mark.parametrize("sign", [signal.SIGKILL, signal.SIGINT])
def test_killed_at_any_moment_and_started_again_it_writes_the_same_bytes(tmp_path: Path, sign: int) -> None:
    root = write_frames(tmp_path / "synscapes", 20)
    options = ["--beta", "0.01", "--beta", "0.03", "--transmittance"]
    assert fog(root, tmp_path / "whole", *options) == 0
    command = [*FOGGY, "fog", "--synscapes", str(root), *options, "--jobs", "2"]
    out = tmp_path / "out"
    for wanted in (1, 30):
        with subprocess.Popen(
            [*command, "--out", str(out)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
        ) as process:
            while len(images(out)) < wanted and process.poll() is None:
                time.sleep(0.002)
            assert process.poll() is None, process.stderr.read()
            os.kill(process.pid, sign)
            assert b"Traceback" not in process.stderr.read()
        for path in out.rglob("[!.]*.png"):
            assert path.read_bytes() == (tmp_path / "whole" / path.relative_to(out)).read_bytes()
    assert fog(root, out, *options) == 0
    assert tree(out) == tree(tmp_path / "whole")


def test_help_needs_no_numba(tmp_path: Path) -> None:
    shutil.copytree(
        Path(__file__).resolve().parents[2] / "src", tmp_path / "src", ignore=shutil.ignore_patterns("*.pyc")
    )
    code = "import sys; sys.argv = ['foggy', 'fog', '--help']\nfrom foggy_synscapes.cli import main\nmain()\n"
    code += "assert not {'numba', 'torch', 'OpenEXR', 'pandas', 'matplotlib'} & set(sys.modules), sys.modules.keys()"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "1/m" in done.stdout


def test_the_same_frames_may_lie_elsewhere_but_not_be_of_another_camera(root: Path, tmp_path: Path, capsys) -> None:
    other = write_frames(tmp_path / "other", 3)
    assert fog(root, tmp_path / "out") == 0
    before = tree(tmp_path / "out")
    assert fog(other, tmp_path / "out") == 0
    assert "0 images made, 3 kept" in capsys.readouterr().out
    camera = tmp_path / "camera.json"
    camera.write_text(camera_json())
    error = failure(capsys, fog(root, tmp_path / "out", "--camera", str(camera)))
    assert "camera was meta files, now one file" in error
    assert tree(tmp_path / "out") == before


def test_an_image_that_is_replaced_by_an_older_one_gets_new_fog(root: Path, tmp_path: Path) -> None:
    out, image = tmp_path / "out", root / "img/rgb/1.png"
    assert fog(root, out) == 0
    time.sleep(0.05)
    image.write_bytes(encode_png(np.full((*SIZE, 3), 77, np.uint8)))
    os.utime(image, (1e9, 1e9))
    assert fog(root, out) == 0
    assert list(read_csv(out / "airlight.csv")[0].values()) == ["1", "77", "77", "77", "0", "0"]
