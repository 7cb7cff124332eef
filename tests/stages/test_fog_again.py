"""foggy fog run again in the same folder: what is kept was made of the same inputs, beside other runs too."""

import io
import json
import re
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from fog_frames import CAMERA, SIZE, camera_json, content, write_frame, write_frames
from PIL import Image

from foggy_synscapes.camera import Camera
from foggy_synscapes.cli import main
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.frames import rendering, settings
from foggy_synscapes.io.images import encode_depth, encode_png, read_rgb
from foggy_synscapes.io.tables import read_csv

FAR = Camera(400.0, 400.0, 20.5, 11.5, CAMERA.resx, CAMERA.resy)


@pytest.fixture
def root(tmp_path: Path) -> Path:
    return write_frames(tmp_path / "synscapes", 3)


def fog(root: Path, out: Path, *options: str) -> int:
    return main(["fog", "--synscapes", str(root), "--beta", "0.02", "--out", str(out), *options])


def foggy(out: Path, frame: int) -> np.ndarray:
    return read_rgb(out / f"beta_0.02/foggy_img/{frame:05d}_beta_0.02.png")


def test_one_frame_by_another_camera_is_refused(root: Path, tmp_path: Path, capsys) -> None:
    """Both files are older than the images: times tell nothing."""
    one, other = tmp_path / "one.json", tmp_path / "other.json"
    one.write_text(camera_json())
    other.write_text(camera_json(FAR))
    assert fog(root, tmp_path / "out", "--ids", "1", "--camera", str(one)) == 0
    assert fog(root, tmp_path / "out", "--ids", "1", "--camera", str(other)) == 1
    error = capsys.readouterr().err
    assert "the file of the camera has other content" in error
    assert re.search(r"[0-9a-f]{16}", error.partition("settings.json")[2]) is None  # digests tell a reader nothing


def test_a_call_that_made_no_image_does_not_bind_the_next_one(root: Path, tmp_path: Path, capsys) -> None:
    """Depth without a camera in its header, in four calls: none of them made an image until the camera was named."""
    out = tmp_path / "out"
    for _ in range(2):
        assert fog(root, out, "--camera-in-depth") == 1
        assert "img/depth/1.exr: its header has no camera:zoom" in capsys.readouterr().err
    assert not (out / "settings.json").exists()
    (tmp_path / "camera.json").write_text(camera_json())
    assert fog(root, out, "--geometry", "exact", "--camera", str(tmp_path / "camera.json")) == 0
    assert json.loads((out / "settings.json").read_text())["geometry"] == "exact"
    assert fog(root, out, "--camera", str(tmp_path / "camera.json")) == 1
    assert "geometry was exact, now paper" in capsys.readouterr().err


def test_frames_that_were_left_out_bind_the_folder_too(tmp_path: Path, capsys) -> None:
    """That a frame was left out is known from then on, and would be wrong where it is to be kept."""
    root, out = tmp_path / "synscapes", tmp_path / "out"
    write_frame(root, 5)
    assert fog(root, out, "--blue-airlight", "drop") == 0
    assert fog(root, out, "--blue-airlight", "keep") == 1
    assert "blue_airlight was drop, now keep" in capsys.readouterr().err


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_of_two_first_calls_with_other_settings_one_is_refused(root: Path, tmp_path: Path, jobs: str) -> None:
    """Both looked when there was nothing; who writes the first image decides what the folder holds."""
    out = tmp_path / "out"
    for name in ("paper", "exact"):
        settings.check(out, settings.text({"geometry": name}), "beta_*/*/[!.]*")
    settings.claim(out, settings.text({"geometry": "exact"}))
    with pytest.raises(FoggyError, match="geometry was exact, now paper"):
        settings.claim(out, settings.text({"geometry": "paper"}))
    assert fog(root, out, "--jobs", jobs) == 1
    assert not list(out.rglob("*.png"))


def test_cameras_of_depth_files_are_not_those_of_meta_files(root: Path, tmp_path: Path, capsys) -> None:
    for frame in (1, 2, 3):
        header = {"image:window": (np.zeros(2, np.float32), np.ones(2, np.float32)), "camera:zoom": 10.0}
        OpenEXR.File(header, {"Z": content(frame)[1]}).write(str(root / f"img/depth/{frame}.exr"))
    assert fog(root, tmp_path / "out") == 0
    assert fog(root, tmp_path / "out", "--camera-in-depth") == 1
    assert "camera was meta files, now depth files" in capsys.readouterr().err


def test_a_job_may_grow_from_one_frame_to_all(root: Path, tmp_path: Path, capsys) -> None:
    (tmp_path / "camera.json").write_text(camera_json())
    camera = "--camera", str(tmp_path / "camera.json")
    assert fog(root, tmp_path / "out", "--ids", "1", *camera) == 0
    assert fog(root, tmp_path / "out", *camera) == 0
    assert "2 images made, 1 kept" in capsys.readouterr().out


def test_a_link_that_is_pointed_at_an_older_image_gets_new_fog(root: Path, tmp_path: Path) -> None:
    image, older = root / "img/rgb/1.png", tmp_path / "older.png"
    older.write_bytes(encode_png(np.full((*SIZE, 3), 77, np.uint8)))
    image.rename(tmp_path / "first.png")
    image.symlink_to(tmp_path / "first.png")
    assert fog(root, tmp_path / "out") == 0
    assert not (foggy(tmp_path / "out", 1) == 77).all()
    time.sleep(0.05)
    image.unlink()
    image.symlink_to(older)
    assert fog(root, tmp_path / "out") == 0
    assert (foggy(tmp_path / "out", 1) == 77).all()


@pytest.mark.parametrize("content", [None, "[]", "{"])
def test_images_without_settings_are_not_taken_over(root: Path, tmp_path: Path, capsys, content: str | None) -> None:
    out = tmp_path / "out"
    assert fog(root, out) == 0
    (out / "settings.json").unlink()
    if content is not None:
        (out / "settings.json").write_text(content)
    assert fog(root, out) == 1
    error = capsys.readouterr().err
    assert "settings.json: " in error
    assert "Error" not in error


def test_two_runs_side_by_side_keep_each_others_rows(tmp_path: Path) -> None:
    root, out = write_frames(tmp_path / "synscapes", 24), tmp_path / "out"
    call = [sys.executable, "-m", "foggy_synscapes", "fog", "--synscapes", str(root), "--beta", "0.02", "--out"]
    runs = [subprocess.Popen([*call, str(out), "--ids", ids], stderr=subprocess.PIPE) for ids in ("1-12", "13-24")]
    assert [run.wait() for run in runs] == [0, 0], [run.stderr.read() for run in runs]
    assert [row["id"] for row in read_csv(out / "airlight.csv")] == [str(frame) for frame in range(1, 25)]


def test_what_a_kill_left_is_removed_and_what_is_strange_is_left_alone(root: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert fog(root, out) == 0
    images = out / "beta_0.02/foggy_img"
    own = [out / ".settings.json.0a1b.part", out / ".airlight.csv.0a1b.part", images / ".00001_beta_0.02.png.0a1b.part"]
    strange = [out / "beta_0.02/.DS_Store", images / ".00099_beta_0.02.png.0a1b.part"]
    for path in (*own, *strange):
        path.write_bytes(b"half")
    (images / ".f.part").mkdir()
    assert fog(root, out) == 0
    assert not any(path.exists() for path in own)
    assert all(path.exists() for path in strange)


def test_more_processes_than_frames_are_not_started(root: Path, tmp_path: Path) -> None:
    assert fog(root, tmp_path / "out", "--jobs", "100000") == 0
    assert len(read_csv(tmp_path / "out/airlight.csv")) == 3


def test_a_header_that_describes_no_camera_is_named(root: Path, tmp_path: Path, capsys) -> None:
    header = {"image:window": 1.5, "camera:zoom": 10.0}
    OpenEXR.File(header, {"Z": content(2)[1]}).write(str(root / "img/depth/2.exr"))
    (root / "img/depth/1.exr").unlink()
    assert fog(root, tmp_path / "out", "--camera-in-depth", "--keep-going") == 1
    error = capsys.readouterr().err
    assert "img/depth/2.exr: camera in its header: " in error
    assert "3 of 3 frames broken" in error


def test_a_frame_that_fails_as_no_check_foresaw_is_named(root: Path, tmp_path: Path, capsys, monkeypatch) -> None:
    read = rendering.read_clear

    def strange(*frame: object) -> rendering.Clear:
        return read(*frame) if Path(frame[2]).stem != "2" else {}["nothing like it"]

    monkeypatch.setattr(rendering, "read_clear", strange)
    assert fog(root, tmp_path / "out", "--keep-going") == 1
    error = capsys.readouterr().err
    assert "img/rgb/2.png: frame 2 cannot be fogged: KeyError: 'nothing like it'" in error
    assert "1 of 3 frames broken" in error
    assert [row["id"] for row in read_csv(tmp_path / "out/airlight.csv")] == ["1", "3"]


def plain(tmp_path: Path, name: str, image: bytes) -> list[str]:
    for folder, file, data in (("rgb", name, image), ("depth", "a.exr", encode_depth(content(1)[1]))):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / file).write_bytes(data)
    (tmp_path / "camera.json").write_text(camera_json())
    options = ["--rgb", "--depth", "--camera", "--out"]
    paths = [str(tmp_path / name) for name in ("rgb", "depth", "camera.json", "out")]
    return ["fog", *(part for pair in zip(options, paths, strict=True) for part in pair), "--beta", "0.02"]


def test_a_jpeg_is_read_whole_or_refused(tmp_path: Path, capsys) -> None:
    buffer = io.BytesIO()
    Image.fromarray(content(1)[0]).save(buffer, "JPEG", quality=95)
    call = plain(tmp_path, "a.jpg", buffer.getvalue())
    assert main(call) == 0
    (tmp_path / "rgb/a.jpg").write_bytes(buffer.getvalue()[:-200])
    assert main(call) == 1
    assert "rgb/a.jpg: cut off at" in capsys.readouterr().err


def test_a_name_that_no_table_can_hold_is_refused_before_any_work(tmp_path: Path, capsys) -> None:
    call = plain(tmp_path, "a.png", encode_png(content(1)[0]))
    (tmp_path / "rgb/a.png").rename(tmp_path / "rgb" / b"\xff.png".decode("utf-8", "surrogateescape"))
    assert main(call) == 1
    assert "its name is not UTF-8" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_names_with_leading_zeros_stay_so_that_they_pair_with_their_labels(tmp_path: Path) -> None:
    call = plain(tmp_path, "0000000001.png", encode_png(content(1)[0]))
    (tmp_path / "depth/a.exr").rename(tmp_path / "depth/0000000001.exr")
    assert main(call) == 0
    assert [path.name for path in (tmp_path / "out").rglob("*.png")] == ["0000000001_beta_0.02.png"]
    assert [row["id"] for row in read_csv(tmp_path / "out/airlight.csv")] == ["0000000001"]


def test_padded_names_are_other_files(root: Path, tmp_path: Path, capsys) -> None:
    (root / "img/rgb/01.png").write_bytes(b"")
    assert fog(root, tmp_path / "out") == 0
    assert "3 frames, 1 betas, 3 images made" in capsys.readouterr().out
    assert set(json.loads((tmp_path / "out/settings.json").read_text())) >= {"camera", "code"}
    assert fog(root, tmp_path / "out", "--ids", "") == 2
