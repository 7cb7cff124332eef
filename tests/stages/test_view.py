"""The command view: a page of a frame, pages of a finished run, and what it refuses."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from finished_run import TEST_SET, finished_run
from fog_frames import CAMERA, camera_json, content, write_frame

from foggy_synscapes.cli import main
from foggy_synscapes.fog.airlight import estimate
from foggy_synscapes.io.atomic import write_bytes, write_text
from foggy_synscapes.io.images import encode_png

PAGE = Path(f"results/view/{TEST_SET}.html")


def facts(page: Path) -> dict:
    return json.loads(re.search(r'id="facts">(.*?)</script>', page.read_text("utf-8"))[1])


@pytest.fixture
def frame(tmp_path: Path) -> list[str]:
    """Options of a frame whose camera stands alone, without those of the page."""
    write_frame(tmp_path, 1)
    write_text(tmp_path / "camera.json", camera_json())
    rgb, depth = tmp_path / "img/rgb/1.png", tmp_path / "img/depth/1.exr"
    return ["view", "--rgb", str(rgb), "--depth", str(depth), "--camera", str(tmp_path / "camera.json")]


def test_a_frame_becomes_a_page_with_its_airlight(frame: list[str], tmp_path: Path, capsys) -> None:
    out = tmp_path / "new folder/frame.html"
    assert main([*frame, "--out", str(out)]) == 0
    assert str(out) in capsys.readouterr().out
    found, light = facts(out), estimate(content(1)[0])
    assert (found["width"], found["height"]) == (CAMERA.resx, CAMERA.resy)
    assert tuple(found["airlight"]) == light.levels
    assert found["taken"] == [light.row, light.column]
    assert found["beta"] == 0.02


def test_airlight_density_and_geometry_are_those_asked_for(frame: list[str], tmp_path: Path) -> None:
    out = tmp_path / "frame.html"
    options = ["--airlight", "10, 20,30", "--beta", "0.06", "--geometry", "exact", "--out", str(out)]
    assert main([*frame, *options]) == 0
    found = facts(out)
    assert (found["airlight"], found["beta"]) == ([10, 20, 30], 0.06)
    assert tuple(found["estimated"]) == estimate(content(1)[0]).levels
    assert main([*frame, "--visibility", "150", "--out", str(out)]) == 0
    assert facts(out)["nearest"] != found["nearest"]
    assert facts(out)["beta"] == 0.01997


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ([], "give --rgb, --depth, --camera and --out for a frame, or --results"),
        (["--rgb", "a.png", "--results"], "for a frame, or --results"),
        (["--rgb", "a.png"], "a frame is --rgb, --depth, --out and --camera"),
        (["--rgb", "a", "--depth", "b", "--camera", "c", "--out", "d", "--test-set", "e"], "belongs to --results"),
        (["--rgb", "a", "--depth", "b", "--camera", "c", "--out", "d", "--beta", "-1"], "--beta -1.0: expected"),
        (
            ["--rgb", "a", "--depth", "b", "--camera", "c", "--out", "d", "--airlight", "1,2"],
            "--airlight 1,2: expected",
        ),
        (["--rgb", "a", "--depth", "b", "--camera", "c", "--out", "d", "--airlight", "1,2,256"], "three levels"),
    ],
)
def test_a_wrong_call_ends_with_status_2(options: list[str], message: str, capsys) -> None:
    assert main(["view", *options]) == 2
    assert message in capsys.readouterr().err


def test_files_that_do_not_belong_together_are_named(frame: list[str], tmp_path: Path, capsys) -> None:
    write_bytes(tmp_path / "img/rgb/1.png", encode_png(content(1)[0][:-1]))
    assert main([*frame, "--out", str(tmp_path / "frame.html")]) == 1
    assert "40 x 24 pixels, but" in capsys.readouterr().err
    assert not (tmp_path / "frame.html").exists()


def test_depth_in_other_units_and_an_angle_of_view_do_too(frame: list[str], tmp_path: Path, capsys) -> None:
    millimetres = np.minimum(content(1)[1] * 100, 60_000).astype(np.uint16)
    millimetres[20, 30] = 0
    write_bytes(tmp_path / "depth.png", encode_png(millimetres))
    out = tmp_path / "frame.html"
    options = ["--depth", str(tmp_path / "depth.png"), "--depth-scale", "0.01", "--fov", "60", "--out", str(out)]
    assert main([*frame[:3], *options]) == 1
    assert "--missing far" in capsys.readouterr().err
    assert main([*frame[:3], *options, "--missing", "far"]) == 0
    assert facts(out)["nearest"] >= millimetres[millimetres > 0].min() * 0.01


def test_a_finished_run_becomes_a_page_of_its_rows(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    truth = finished_run()
    assert main(["view", "--results", "--test-set", TEST_SET]) == 0
    assert f"{PAGE}, " in capsys.readouterr().out
    found, first = facts(PAGE), PAGE.read_bytes()
    assert [row["network"] + row["row"] for row in found["rows"]] == [
        "RefineNetC", "RefineNetFS-498", "BiSeNetC", "BiSeNetFS-498"
    ]  # fmt: skip
    assert len(found["images"]) == 3 < len(truth)
    assert {image["name"] for image in found["images"]} <= {*truth}
    scores = json.loads(Path(f"results/evaluate/{TEST_SET}/refinenet/C/seed-0/metrics.json").read_text())
    assert found["rows"][0]["mean"] == scores["mean_iou"]["annotated"]
    record = json.loads(PAGE.with_suffix(".run.json").read_text())
    assert sum(name.endswith("predictions.tar") for name in record["inputs"]) == 4
    assert {"view/templates/view.css", "view/templates/predictions.js"} <= {*record["code"]}
    assert main(["view", "--results", "--test-set", TEST_SET]) == 0
    assert PAGE.read_bytes() == first
    # The other test set of these params was not scored.
    assert main(["view", "--results"]) == 1
    assert "no predictions on foggy_driving" in capsys.readouterr().err
    assert main(["view", "--results", "--test-set", "cityscapes"]) == 2
    assert "evaluate.test_sets has foggy_driving, foggy_zurich" in capsys.readouterr().err


def test_a_frame_is_looked_at_without_what_the_experiment_needs(frame: list[str], tmp_path: Path) -> None:
    unneeded = ("dvc", "jinja2", "matplotlib", "pandas", "snakemake", "torch")
    script = (
        f"import sys; sys.modules.update(dict.fromkeys({unneeded!r}))\n"  # to import one of them is an error
        f"from foggy_synscapes.cli import main; sys.exit(main({[*frame, '--out', str(tmp_path / 'frame.html')]!r}))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "frame.html").is_file()
