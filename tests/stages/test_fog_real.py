"""The real Synscapes samples and the published code's outputs on them: every pixel, through the command."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from foggy_synscapes.cli import main
from foggy_synscapes.fog.airlight import dark_channel
from foggy_synscapes.frames.rendering import read_camera
from foggy_synscapes.io.images import read_ids, read_rgb
from foggy_synscapes.io.tables import read_csv

BETAS = ("0.005", "0.06")
EDGES = ("14x14", "25x40_1000", "3x5", "40x50_2000", "black", "blocks", "fewlevels")


def assert_same_pixels(out: Path, name: str, reference: Path, stem: str) -> None:
    for beta in BETAS:
        for folder, kind, read in (("foggy_img", "foggy", read_rgb), ("transmittance", "transmittance", read_ids)):
            ours = read(out / f"beta_{beta}" / folder / f"{name}_beta_{beta}.png")
            np.testing.assert_array_equal(ours, read(reference / f"{stem}_beta_{beta}_{kind}.png"), f"{stem} {kind}")


def test_both_samples_are_the_published_codes_to_the_pixel(real_data: Path, tmp_path: Path) -> None:
    root, out = real_data / "synscapes", tmp_path / "out"
    options = ["--camera", str(root / "camera.json"), "--geometry", "paper", "--transmittance", "--jobs", "2"]
    betas = [part for beta in BETAS for part in ("--beta", beta)]
    assert main(["fog", "--synscapes", str(root), "--out", str(out), *options, *betas]) == 0
    for frame in (1, 2):
        assert_same_pixels(out, f"{frame:05d}", real_data / "fog_reference", str(frame))
    assert [list(row.values()) for row in read_csv(out / "airlight.csv")] == [
        ["1", "251", "255", "249", "12", "961"],
        ["2", "251", "255", "249", "0", "462"],
    ]


def test_exact_geometry_changes_the_samples_by_one_level_at_most(real_data: Path, tmp_path: Path) -> None:
    root, out = real_data / "synscapes", tmp_path / "out"
    options = ["--camera", str(root / "camera.json"), "--geometry", "exact", "--ids", "1"]
    assert main(["fog", "--synscapes", str(root), "--out", str(out), *options, "--beta", "0.06"]) == 0
    ours = read_rgb(out / "beta_0.06/foggy_img/00001_beta_0.06.png").astype(int)
    difference = np.abs(ours - read_rgb(real_data / "fog_reference/1_beta_0.06_foggy.png"))
    assert difference.max() == 1
    assert 0 < difference.mean() < 0.006


@pytest.mark.parametrize("case", EDGES)
def test_edge_cases_are_the_published_codes_to_the_pixel(real_data: Path, tmp_path: Path, case: str) -> None:
    """The published demo took its camera as it was, whatever the size of the image: here only resx and resy differ.

    It took a depth of 0 as it was, too, as is done with the layout of Synscapes.
    """
    edge, out = real_data / "fog_reference" / "edge", tmp_path / "out"
    for folder, source, name in (("rgb", f"{case}_rgb.png", "1.png"), ("depth", f"{case}.exr", "1.exr")):
        (tmp_path / "img" / folder).mkdir(parents=True)
        shutil.copyfile(edge / source, tmp_path / "img" / folder / name)
    image = read_rgb(edge / f"{case}_rgb.png")
    camera = json.loads((real_data / "synscapes" / "camera.json").read_text())
    camera["camera"]["intrinsic"] |= {"resx": image.shape[1], "resy": image.shape[0]}
    (tmp_path / "camera.json").write_text(json.dumps(camera))
    paths = ["--synscapes", str(tmp_path), "--camera", str(tmp_path / "camera.json")]
    betas = [f"--beta={beta}" for beta in BETAS]
    assert main(["fog", *paths, *betas, "--out", str(out), "--transmittance"]) == 0
    assert_same_pixels(out, "00001", edge, case)
    np.testing.assert_array_equal(dark_channel(image), read_ids(edge / f"{case}_dark.png"))


def test_the_camera_in_the_depth_files_is_the_one_of_the_json(real_data: Path, tmp_path: Path) -> None:
    root = real_data / "synscapes"
    written = read_camera(root / "camera.json")
    for frame in (1, 2):
        found = read_camera(root / f"img/depth/{frame}.exr")
        for name in ("fx", "fy", "u0", "v0"):
            assert getattr(found, name) == pytest.approx(getattr(written, name), abs=4e-6 * written.resx)
        assert (found.resx, found.resy) == (1440, 720)
    out = tmp_path / "out"
    assert (
        main(["fog", "--synscapes", str(root), "--camera-in-depth", "--ids=1", "--beta=0.06", "--out", str(out)]) == 0
    )
    ours = read_rgb(out / "beta_0.06/foggy_img/00001_beta_0.06.png").astype(int)
    difference = np.abs(ours - read_rgb(real_data / "fog_reference/1_beta_0.06_foggy.png"))
    assert difference.max() <= 1
    assert difference.mean() < 1e-4


def test_the_list_of_edge_cases_is_complete(real_data: Path) -> None:
    assert sorted(path.stem for path in (real_data / "fog_reference" / "edge").glob("*.exr")) == sorted(EDGES)
