"""docs/recipes.md: each command of the page runs on generated files of its layout, and gives the fog that it says."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from fog_frames import tree
from recipe_frames import FX, RECIPES, SIZE, kitti_2015, street

from foggy_synscapes.camera import Camera
from foggy_synscapes.cli import main
from foggy_synscapes.fog.airlight import estimate
from foggy_synscapes.fog.geometry import rays, straight
from foggy_synscapes.fog.optics import foggy_images
from foggy_synscapes.io.images import read_ids, read_rgb

PAGE = Path(__file__).resolve().parents[2] / "docs/recipes.md"
COMMANDS = re.findall(r"```sh\n(foggy fog .+)\n```", PAGE.read_text())
CAMERA = Camera(FX, FX, 20.0, 12.0, SIZE[1], SIZE[0])


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def foggy(image: np.ndarray, depth: np.ndarray, beta: float, camera: Camera | None = CAMERA) -> np.ndarray:
    lines = straight(SIZE) if camera is None else rays(camera)
    return foggy_images(image, depth.astype(np.float32), lines, estimate(image).levels, [beta])[0]


def run(command: str) -> int:
    return main(shlex.split(command)[1:])


def of(part: str) -> str:
    (command,) = [command for command in COMMANDS if part in command]
    return command


def images(out: Path, ending: str = "") -> list[str]:
    return [name for name in tree(out) if name.endswith((".png", ".jpg")) and name.endswith(ending)]


def test_the_page_has_every_recipe() -> None:
    assert len(COMMANDS) == len(RECIPES) == 13
    assert all(of(part) for part in RECIPES)


@pytest.mark.parametrize("part", RECIPES)
def test_each_recipe_runs_as_one_command_and_again(here: Path, part: str, capsys) -> None:
    if part == "indoor_depth":
        pytest.importorskip("scipy", reason="MATLAB files need SciPy")
    make, count = RECIPES[part]
    make(here)
    assert run(of(part)) == 0, capsys.readouterr().err
    kind = "foggy_img" if "cityscapes" not in part else "leftImg8bit_foggy"
    first = tree(here / "out")
    assert len([name for name in images(here / "out") if kind in name]) == count
    assert run(of(part)) == 0
    assert tree(here / "out") == first
    assert " 0 images made" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("part", "names"),
    [
        ("samples/", ["CAM_BACK/n015-1_beta_0.01.jpg", "CAM_FRONT/n015-0_beta_0.01.jpg"]),
        ("drives/", ["monday/front/1_rgb_beta_0.01.png", "tuesday/2_rgb_beta_0.01.png"]),
        ("--layout vkitti", [f"Scene01/clone/frames/rgb/Camera_0/rgb_0000{n}_beta_0.01.png" for n in (0, 1)]),
        ("photo.jpg", ["photo_beta_0.05992.png"]),
    ],
)
def test_names_and_folders_are_kept(here: Path, part: str, names: list[str]) -> None:
    RECIPES[part][0](here)
    assert run(of(part)) == 0
    assert [name.partition("foggy_img/")[2] for name in images(here / "out")] == names


def test_carla_and_virtual_kitti_are_metres_and_sky(here: Path) -> None:
    image, depth = street()
    RECIPES["--layout carla"][0](here)
    assert run(of("--layout carla")) == 0
    focal = 20 / np.tan(np.radians(50))
    camera = Camera(round(float(focal), 9), round(float(focal), 9), 20.0, 12.0, SIZE[1], SIZE[0])
    name = "out/beta_0.01/foggy_img/run1/rgb_left/000042_beta_0.01.png"
    assert np.abs(read_rgb(here / name).astype(int) - foggy(image, depth, 0.01, camera)).max() <= 1  # 0.06 mm a unit
    assert (read_rgb(here / name)[:6] == (251, 255, 249)).all()


def test_disparity_gives_depth_by_baseline_and_focal_length(here: Path) -> None:
    image, depth = street()
    kitti_2015(here)
    command = "foggy fog --layout kitti --root kitti --depth-from disparity --missing far --beta 0.02 --out out"
    assert run(command) == 0
    found = read_rgb(here / "out/beta_0.02/foggy_img/training/image_2/000000_10_beta_0.02.png").astype(int)
    assert np.abs(found - foggy(image, depth, 0.02)).max() <= 2  # disparity is rounded to 1/256 of a pixel
    assert (found[:6] == (251, 255, 249)).all()


def test_depth_along_the_ray_is_taken_as_it_is(here: Path) -> None:
    RECIPES["--depth-is ray"][0](here)
    assert run(of("--depth-is ray").replace("0.01 --out", "0.01 --transmittance --out")) == 0
    _, depth = street()
    maps = read_ids(here / "out/beta_0.01/transmittance/a_beta_0.01.png")
    np.testing.assert_array_equal(maps, np.floor(255 * np.exp(-0.01 * np.minimum(depth, 9000)) + 0.5))


def test_a_published_map_gives_the_fog_that_it_says(here: Path) -> None:
    RECIPES["--transmittance-map"][0](here)
    assert run(of("--transmittance-map")) == 0
    image, depth = street()
    (name,) = images(here / "out", "0.01.png")
    t = np.floor(255 * np.exp(-0.01 * depth) + 0.5)[..., None] / 255
    light = np.array(estimate(image).levels)
    np.testing.assert_array_equal(read_rgb(here / "out" / name), np.floor(t * image + (1 - t) * light + 0.5))


def test_kitti_completes_and_says_so(here: Path, capsys) -> None:
    RECIPES["--layout kitti"][0](here)
    assert run(of("--layout kitti")) == 0
    assert "0000000001.png: 600 of 960 pixels (62.5%) have no depth, and were completed" in capsys.readouterr().err
    image, depth = street(1)
    name = "train/2011_09_26_drive_0001_sync/proj_depth/groundtruth/image_02/0000000001"
    found = read_rgb(here / f"out/beta_0.02/foggy_img/{name}_beta_0.02.png").astype(int)
    road = np.s_[14:, 1::2]  # what was measured
    assert np.abs(found - foggy(image, depth, 0.02))[road].max() <= 1
