"""foggy complete and foggy fog on the layout of Cityscapes: fog and depth from stereo, through the command."""

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fog_frames import tree
from stereo_frames import NAMES, SIZE, camera, content, write, write_all

from foggy_synscapes.camera import Camera
from foggy_synscapes.cli import main
from foggy_synscapes.datasets import cityscapes
from foggy_synscapes.depth import annotation, refinement
from foggy_synscapes.depth.completion import Stereo, complete
from foggy_synscapes.fog.airlight import estimate
from foggy_synscapes.fog.geometry import rays
from foggy_synscapes.io.arrays import read_npz
from foggy_synscapes.io.images import encode_png, read_ids, read_rgb
from foggy_synscapes.io.tables import read_csv

CAMERA = Camera(350.0, 350.0, 161.0, 99.0, SIZE[1], SIZE[0])
FIRST = NAMES[0]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_all(tmp_path_factory.mktemp("stereo") / "cityscapes")


@pytest.fixture
def root(made: Path, tmp_path: Path) -> Path:
    """A copy that may be spoiled."""
    return shutil.copytree(made, tmp_path / "cityscapes")


def fog(root: Path, out: Path, *options: str) -> int:
    return main(["fog", "--layout", "cityscapes", "--root", str(root), "--out", str(out), *options])


def foggy(out: Path, name: str, beta: str, ending: str = "") -> np.ndarray:
    return read_rgb(out / f"leftImg8bit_foggy{ending}" / f"{name}_leftImg8bit_foggy_beta_{beta}.png")


def expected(seed: int, beta: float, labels: bool) -> np.ndarray:
    arrays = content(seed)
    left = arrays["left"]
    depth = complete(left, arrays["right"], arrays["disparity"], Stereo(CAMERA, 0.22)).depth
    refine = refinement.bilateral(left, annotation.labels(arrays["ids"])) if labels else refinement.guided(left)
    return refinement.composite(left, refine(refinement.initial(depth, rays(CAMERA), beta)), estimate(left).levels)


def test_foggy_cityscapes_is_made_under_its_published_names(made: Path, tmp_path: Path) -> None:
    assert fog(made, tmp_path / "out", "--beta", "0.01", "--beta", "0.02") == 0
    files = sorted(path for path in tree(tmp_path / "out") if path.endswith(".png"))
    assert files == sorted(
        f"leftImg8bit_foggy/{name}_leftImg8bit_foggy_beta_{beta}.png" for name in NAMES for beta in ("0.01", "0.02")
    )
    for seed, name in enumerate(NAMES):
        np.testing.assert_array_equal(foggy(tmp_path / "out", name, "0.02"), expected(seed, 0.02, labels=False))
    light = estimate(content(0)["left"])
    first = read_csv(tmp_path / "out/airlight.csv")[0]
    assert list(first.values()) == [FIRST, *map(str, (*light.levels, light.row, light.column))]


def test_the_bilateral_filter_has_a_folder_of_its_own(made: Path, tmp_path: Path) -> None:
    assert fog(made, tmp_path / "out", "--beta", "0.01", "--refine", "bilateral", "--split", "val") == 0
    assert [path for path in tree(tmp_path / "out") if path.endswith(".png")] == [
        f"leftImg8bit_foggyDBF/{NAMES[2]}_leftImg8bit_foggy_beta_0.01.png"
    ]
    np.testing.assert_array_equal(foggy(tmp_path / "out", NAMES[2], "0.01", "DBF"), expected(2, 0.01, labels=True))


def test_complete_writes_depth_transmittance_and_airlight(made: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    call = ["complete", "--layout", "cityscapes", "--root", str(made), "--out", str(out)]
    assert main([*call, "--split", "train", "--beta", "0.01"]) == 0
    arrays = content(0)
    depth = complete(arrays["left"], arrays["right"], arrays["disparity"], Stereo(CAMERA, 0.22)).depth
    np.testing.assert_array_equal(read_npz(out / f"depth/{FIRST}_depth.npz", "depth"), depth)
    values = refinement.guided(arrays["left"])(refinement.initial(depth, rays(CAMERA), 0.01))
    map_ = out / f"leftImg8bit_transmittance/{FIRST}_leftImg8bit_transmittance_beta_0.01.png"
    np.testing.assert_array_equal(read_ids(map_), refinement.levels(values))
    assert sorted(path.split("/")[0] for path in tree(out)) == sorted(
        ["airlight.csv", "made.csv", "settings.json", *["depth"] * 2, *["leftImg8bit_transmittance"] * 2]
    )


def test_complete_needs_no_beta_and_no_labels(root: Path, tmp_path: Path) -> None:
    shutil.rmtree(root / "gtFine")
    call = ["complete", "--layout", "cityscapes", "--root", str(root), "--out", str(tmp_path / "out")]
    assert main([*call, "--split", "val"]) == 0
    assert (tmp_path / f"out/depth/{NAMES[2]}_depth.npz").is_file()


def test_a_list_names_the_refined_frames(made: Path, tmp_path: Path) -> None:
    (tmp_path / "refined.txt").write_text(f"{NAMES[2]}\n{NAMES[0]}\n")
    assert fog(made, tmp_path / "out", "--beta", "0.01", "--list", str(tmp_path / "refined.txt")) == 0
    assert [row["id"] for row in read_csv(tmp_path / "out/airlight.csv")] == [NAMES[0], NAMES[2]]


def test_two_processes_and_an_interrupted_run_give_the_same_bytes(made: Path, tmp_path: Path, capsys) -> None:
    betas = ("--beta", "0.01", "--beta", "0.02")
    assert fog(made, tmp_path / "one", *betas) == 0
    assert fog(made, tmp_path / "two", *betas, "--jobs", "2") == 0
    assert tree(tmp_path / "one") == tree(tmp_path / "two")
    folder = tmp_path / "two/leftImg8bit_foggy"
    cut = folder / f"{NAMES[1]}_leftImg8bit_foggy_beta_0.02.png"
    cut.write_bytes(cut.read_bytes()[:1000])
    (folder / f"{NAMES[2]}_leftImg8bit_foggy_beta_0.01.png").unlink()
    (tmp_path / "two/airlight.csv").unlink()
    capsys.readouterr()
    assert fog(made, tmp_path / "two", *betas) == 0
    assert "2 images made, 4 kept" in capsys.readouterr().out
    assert tree(tmp_path / "one") == tree(tmp_path / "two")


def test_splits_made_one_after_the_other_are_those_made_at_once(made: Path, tmp_path: Path) -> None:
    for split in ("val", "train"):
        assert fog(made, tmp_path / "one", "--beta", "0.01", "--split", split) == 0
    assert fog(made, tmp_path / "two", "--beta", "0.01") == 0
    assert tree(tmp_path / "one") == tree(tmp_path / "two")


def test_a_folder_holds_fog_of_one_refinement_and_seed(made: Path, tmp_path: Path, capsys) -> None:
    one = ("--beta", "0.01", "--split", "val")
    assert fog(made, tmp_path / "out", *one) == 0
    assert fog(made, tmp_path / "out", *one, "--refine", "bilateral") == 1
    assert "refine was guided, now bilateral" in capsys.readouterr().err
    assert fog(made, tmp_path / "out", *one, "--seed", "1") == 1
    assert "seed was 5489, now 1" in capsys.readouterr().err


def test_another_seed_gives_other_fog(made: Path, tmp_path: Path) -> None:
    one = ("--beta", "0.01", "--split", "val")
    assert fog(made, tmp_path / "a", *one) == 0
    assert fog(made, tmp_path / "b", *one, "--seed", "1") == 0
    assert not np.array_equal(foggy(tmp_path / "a", NAMES[2], "0.01"), foggy(tmp_path / "b", NAMES[2], "0.01"))


def spoil(root: Path, key: str, pixels: np.ndarray) -> None:
    write(root, FIRST, {key: pixels})


def spoiled(what: str, root: Path) -> None:
    arrays = content(0)
    if what == "disparity of another size":
        spoil(root, "disparity", arrays["disparity"][::2, ::2].copy())
    elif what == "right of another size":
        spoil(root, "right", arrays["right"][:, 1:].copy())
    elif what == "swapped":
        write(root, FIRST, {"left": arrays["right"], "right": arrays["left"]})
    elif what == "no baseline":
        write(root, FIRST, {}, camera(baseline=None))
    elif what == "baseline zero":
        write(root, FIRST, {}, camera(baseline=0))
    elif what == "no camera file":
        (root / cityscapes.camera(FIRST)).unlink()
    elif what == "camera no JSON":
        (root / cityscapes.camera(FIRST)).write_text("fx: 3")
    elif what == "8 bits":
        spoil(root, "disparity", (arrays["disparity"] >> 8).astype(np.uint8))
    elif what == "all invalid":
        spoil(root, "disparity", arrays["disparity"] * 0)
    elif what == "hardly any valid":
        spoil(root, "disparity", np.where(np.arange(SIZE[1]) % 4 == 0, arrays["disparity"], 0).astype(np.uint16))
    elif what == "labels of another size":
        spoil(root, "ids", arrays["ids"][1:].copy())
    elif what == "labels out of roi":
        spoil(root, "ids", np.full(SIZE, 3, np.uint16))
    elif what == "small":
        write(root, FIRST, {key: pixels[:50, :100].copy() for key, pixels in arrays.items()})
    else:
        raise KeyError(what)


@pytest.mark.parametrize(
    ("what", "file", "said"),
    [
        ("disparity of another size", cityscapes.disparity, "160 x 100 pixels, but"),
        ("right of another size", cityscapes.right, "319 x 200 pixels, but"),
        ("swapped", cityscapes.image, "with both swapped. Swap left and right."),
        ("no baseline", cityscapes.camera, "extrinsic.baseline missing, in metres between both cameras"),
        ("baseline zero", cityscapes.camera, "baseline is 0.0, expected metres above 0"),
        ("no camera file", cityscapes.camera, "missing"),
        ("camera no JSON", cityscapes.camera, "not a readable camera file"),
        ("8 bits", cityscapes.disparity, "8-bit grey, expected 16-bit grey. An 8-bit copy has lost its precision."),
        ("all invalid", cityscapes.disparity, "all values are 0, so no pixel has a disparity"),
        ("hardly any valid", cityscapes.disparity, "superpixels has 20 pixels, and 60% of its own"),
        ("labels of another size", cityscapes.instances, "320 x 199 pixels, but the image has 320 x 200"),
        ("labels out of roi", cityscapes.instances, "all pixels are 3, out of roi"),
        ("small", cityscapes.disparity, "100 x 50 pixels, expected four or more for each of 2048 superpixels"),
    ],
)
def test_bad_input_is_named(root: Path, tmp_path: Path, capsys, what: str, file: Any, said: str) -> None:
    spoiled(what, root)
    assert fog(root, tmp_path / "out", "--beta", "0.01", "--refine", "bilateral", "--split", "train") == 1
    message = capsys.readouterr().err
    assert str(root / file(FIRST)) in message
    assert said in message
    assert not list((tmp_path / "out").rglob("*.png"))


def test_broken_frames_are_named_and_the_others_made(root: Path, tmp_path: Path, capsys) -> None:
    (root / cityscapes.right(FIRST)).unlink()
    assert fog(root, tmp_path / "out", "--beta", "0.01", "--keep-going") == 1
    assert f"{root / cityscapes.right(FIRST)}: missing" in capsys.readouterr().err
    assert len(list((tmp_path / "out").rglob("*.png"))) == 2


def test_a_baseline_in_millimetres_is_warned_of(root: Path, tmp_path: Path, capsys) -> None:
    write(root, FIRST, {}, camera(baseline=220))
    assert fog(root, tmp_path / "out", "--beta", "0.01", "--split", "train") == 0
    message = capsys.readouterr().err
    assert f"{root / cityscapes.camera(FIRST)}: with its baseline of 220 m the median depth is" in message
    assert "Is the baseline in metres" in message


def test_an_image_of_one_colour_is_warned_of(root: Path, tmp_path: Path, capsys) -> None:
    grey = np.full((*SIZE, 3), 128, np.uint8)
    write(root, FIRST, {"left": grey, "right": grey})
    assert fog(root, tmp_path / "out", "--beta", "0.01", "--split", "train") == 0
    assert f"{root / cityscapes.image(FIRST)}: has one colour only" in capsys.readouterr().err


def test_views_of_two_frames_are_warned_of(root: Path, tmp_path: Path, capsys) -> None:
    rng = np.random.default_rng(9)
    write(
        root, FIRST, {"right": np.where(rng.random(SIZE) < 0.6, 0, 1)[..., None].astype(np.uint8) * content(0)["right"]}
    )
    fog(root, tmp_path / "out", "--beta", "0.01", "--split", "train")
    assert "look otherwise" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--layout", "cityscapes"], "give --root"),
        (["--root", "x"], "--root: goes with --layout"),
        (["--layout", "cityscapes", "--root", "ROOT", "--split", "test"], "no split test; there are train, val"),
        (["--layout", "cityscapes", "--root", "nowhere"], "no such folder"),
        (["--layout", "cityscapes", "--root", "ROOT", "--ids", "1"], "--ids: --layout cityscapes names frames"),
        (["--layout", "cityscapes", "--root", "ROOT", "--refine", "not"], "--refine not: expected guided or bilateral"),
        (["--layout", "cityscapes", "--root", "ROOT", "--depth-from", "file"], "depth from stereo only"),
        (["--layout", "cityscapes", "--root", "ROOT", "--seed", "-1"], "--seed -1: expected a whole number"),
        (["--layout", "cityscapes", "--root", "ROOT", "--jobs", "0"], "--jobs 0: expected 1 or more"),
    ],
)
def test_calls_that_make_no_sense_are_refused(made: Path, tmp_path: Path, capsys, options, said: str) -> None:
    filled = [str(made) if word == "ROOT" else word for word in options]
    assert main(["fog", *filled, "--beta", "0.01", "--out", str(tmp_path / "out")]) == 2
    assert said in capsys.readouterr().err


def test_the_real_scene_is_the_published_codes_to_the_pixel(real_data: Path, tmp_path: Path) -> None:
    reference = real_data / "stereo_reference" / "dusseldorf"
    if not reference.is_dir():
        pytest.skip(f"no results of the published stereo code at {reference}")
    name = "train/dusseldorf/dusseldorf_000020_000019"
    (tmp_path / "one.txt").write_text(name)
    for refine, kind, ending in (("guided", "gf", ""), ("bilateral", "dbf", "DBF")):
        options = ("--list", str(tmp_path / "one.txt"), "--refine", refine, "--beta", "0.01")
        assert fog(real_data / "cityscapes", tmp_path / refine, *options) == 0
        np.testing.assert_array_equal(
            foggy(tmp_path / refine, name, "0.01", ending), read_rgb(reference / f"foggy_{kind}_0p01.png")
        )
    settings = json.loads((tmp_path / "guided/settings.json").read_text())
    assert (settings["depth_from"], settings["refine"], settings["seed"]) == ("stereo", "guided", 5489)


def test_a_damaged_depth_file_is_made_again(root: Path, tmp_path: Path) -> None:
    call = ["complete", "--layout", "cityscapes", "--root", str(root), "--out", str(tmp_path / "out"), "--split", "val"]
    assert main(call) == 0
    path = tmp_path / f"out/depth/{NAMES[2]}_depth.npz"
    whole = path.read_bytes()
    path.write_bytes(whole[:-5000])
    assert main(call) == 0
    assert path.read_bytes() == whole
    path.write_bytes(whole[:5000] + bytes(8) + whole[5008:])
    assert main(call) == 0
    assert path.read_bytes() == whole


def compared(one: Path, other: Path, capsys) -> tuple[int, str]:
    capsys.readouterr()
    status = main(["complete", "--compare", str(one), str(other)])
    told = capsys.readouterr()
    return status, told.out + told.err


def test_made_and_downloaded_fog_can_be_compared(tmp_path: Path, capsys) -> None:
    grey = np.full((10, 20, 3), 100, np.uint8)
    spoilt = grey.copy()
    spoilt[0, :5] += np.array([0, 1, 0], np.uint8)
    spoilt[1, :4, 2] += 7
    for folder, pixels in (("made", grey), ("downloaded", spoilt), ("small", grey[1:])):
        for name in NAMES[: 1 if folder == "downloaded" else 2]:
            path = tmp_path / folder / f"leftImg8bit_foggy/{name}_leftImg8bit_foggy_beta_0.01.png"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(encode_png(np.ascontiguousarray(pixels)))
    status, told = compared(tmp_path / "made", tmp_path / "downloaded", capsys)
    assert status == 0
    assert "1 images in both, 1 in one only; 4.500% of the pixels differ, 2.000% by more than 1 level" in told
    assert "at most by 7; mean level 100.00 and 100.06" in told  # (5 x 1 + 4 x 7) / 600
    status, told = compared(tmp_path / "made", tmp_path / "small", capsys)
    assert (status, "of different size" in told) == (1, True)
    (tmp_path / "unpacked/beta_0.01").mkdir(parents=True)
    (tmp_path / "made").rename(tmp_path / "unpacked/beta_0.01/foggy_img")  # as `foggy unpack` makes folders
    status, told = compared(tmp_path / "unpacked", tmp_path / "downloaded", capsys)
    assert status == 0
    (tmp_path / "empty").mkdir()
    status, told = compared(tmp_path / "unpacked", tmp_path / "empty", capsys)
    assert (status, "share no image" in told) == (1, True)
