"""scenes: complete layouts, the same bytes however they are made, and real folders that are only read."""

import json
import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from records import index_of

from foggy_synscapes.datasets import DATASETS, cityscapes, foggy_cityscapes, foggy_driving, foggy_zurich, synscapes
from foggy_synscapes.datasets.index import read_index
from foggy_synscapes.depth import disparity
from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.io.hashing import sha256
from foggy_synscapes.io.images import read_depth, read_grey16, read_ids, read_rgb
from foggy_synscapes.io.plain_yaml import read_yaml
from foggy_synscapes.labels import check_train_ids, to_train_ids
from foggy_synscapes.params import Params, check
from foggy_synscapes.stages.scenes import scenes
from foggy_synscapes.standin.layouts.synscapes import scene as synscapes_scene

ROOT = Path(__file__).resolve().parents[2]
SIZE = (32, 64)
HERE = Path("results/scenes")


def small(**changes: object) -> Params:
    """A stand-in of a few tiny frames; `changes` replace keys of scenes.stand_in or, if "roots", roots."""
    document = read_yaml(ROOT / "params.yaml")
    section = document["scenes"]
    section |= {"shard_frames": 4, "shards": ["0000", "0001"]}
    section["stand_in"] |= {
        "size": list(SIZE),
        "synscapes": 7,
        "cityscapes": {"train": 8, "val": 4},
        "foggy_cityscapes": {"train": 4, "val": 2},
        "cityscapes_stereo": {"train": 3, "val": 1},
        "foggy_driving": {"fine": 3, "coarse": 5},
        "foggy_zurich": 5,
    }
    section["roots"] |= {"cityscapes_stereo": "stand-in"} | changes.pop("roots", {})
    section["stand_in"] |= changes
    document["fog"]["frames"] = {"first": 4, "last": 2}
    for kind in ("pure", "mixed"):
        for entry in document["subset"][kind].values():
            entry |= {"train": 4, "validation": 2}
    return check(document, "params.yaml")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a space in its name, where all datasets were rendered."""
    folder = tmp_path_factory.mktemp("stand in")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for dataset in DATASETS:
            scenes(small(), dataset)
    return folder


@pytest.fixture
def here(made: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(made)
    return made


def contents(folder: Path) -> dict[str, str]:
    return {path.relative_to(folder).as_posix(): sha256(path) for path in folder.rglob("*") if path.is_file()}


def test_the_index_lists_every_file_with_its_hash(here: Path) -> None:
    for dataset in DATASETS:
        names = [path.stem for path in sorted((HERE / "index" / dataset).glob("*.csv"))]
        assert names == (["0000", "0001"] if dataset == "synscapes" else ["all"])
        index = read_index(*(index_of(dataset, name) for name in names))
        assert list(index) == sorted(index) or dataset == "synscapes"
        assert all(sha256(HERE / dataset / path) == digest for path, digest in index.items())
        assert (HERE / dataset / "README.txt").is_file()


def test_synscapes_is_complete(here: Path) -> None:
    root = HERE / "synscapes"
    assert len(read_index(index_of("synscapes", "0000"))) == 4 * 4
    assert len(read_index(index_of("synscapes", "0001"))) == 3 * 4
    for frame in range(1, 8):
        scene = synscapes_scene(2019, SIZE, frame - 1)
        assert np.array_equal(read_rgb(root / synscapes.rgb(frame)), scene.rgb)
        depth = read_depth(root / synscapes.depth(frame))
        assert depth.dtype == np.float32
        assert np.array_equal(depth, scene.depth)
        to_train_ids(read_ids(root / synscapes.class_(frame)), "class")
        red, green, blue = np.moveaxis(read_rgb(root / synscapes.instance(frame)).astype(np.uint32), -1, 0)
        assert np.array_equal(red + 256 * green + 65536 * blue, scene.instances)
        meta = synscapes.read_meta(root / synscapes.meta(frame))
        assert (meta.camera.resy, meta.camera.resx) == SIZE
        assert meta.instances == scene.instance
    cameras = {synscapes.read_meta(root / synscapes.meta(frame)).camera for frame in range(1, 8)}
    assert len(cameras) == 7


def test_cityscapes_is_complete(here: Path) -> None:
    root, index = HERE / "cityscapes", read_index(index_of("cityscapes"))
    for split, count in (("train", 8), ("val", 4)):
        names = cityscapes.frames(index, split)
        assert len(names) == count
        for name in names:
            labels = read_ids(root / cityscapes.labels(name))
            to_train_ids(labels, name)
            assert read_rgb(root / cityscapes.image(name)).shape == (*SIZE, 3)
            instances = read_grey16(root / cityscapes.instances(name))
            assert np.array_equal(np.where(instances >= 1000, instances // 1000, instances), labels)
            assert (read_grey16(root / cityscapes.disparity(name)) == 0).any()
            camera = json.loads((root / cityscapes.camera(name)).read_text())
            assert set(camera["extrinsic"]) == {"baseline", "pitch", "roll", "x", "y", "yaw", "z"}
            assert set(camera["intrinsic"]) == {"fx", "fy", "u0", "v0"}


def test_the_stereo_part_is_of_cityscapes_frames_and_its_views_agree(here: Path) -> None:
    root, names = HERE / "cityscapes_stereo", cityscapes.frames(read_index(index_of("cityscapes_stereo")), "train")
    assert len(names) == 3
    for name in names:
        for kind in (cityscapes.image, cityscapes.disparity, cityscapes.camera, cityscapes.instances):
            assert (root / kind(name)).read_bytes() == (HERE / "cityscapes" / kind(name)).read_bytes()
        left, right = read_rgb(root / cityscapes.image(name)), read_rgb(root / cityscapes.right(name))
        stored = read_grey16(root / cityscapes.disparity(name))
        matched = stored > 0
        assert disparity.inconsistent(left, right, stored)[matched].mean() < 0.15
        assert disparity.inconsistent(left, left, stored)[matched].mean() > 0.2


def test_foggy_cityscapes_belongs_to_cityscapes(here: Path) -> None:
    root, clear = HERE / "foggy_cityscapes", HERE / "cityscapes"
    refined = foggy_cityscapes.read_refined(root, small().scenes.refined_list)
    assert [len(refined[split]) for split in ("train", "val")] == [4, 2]
    for name in refined["train"] + refined["val"]:
        image = read_rgb(clear / cityscapes.image(name)).astype(int)
        foggy = [read_rgb(root / foggy_cityscapes.image(name, beta)) for beta in foggy_cityscapes.BETAS]
        change = [np.abs(image - one).mean() for one in foggy]
        assert change == sorted(change)
        hood = read_ids(clear / cityscapes.labels(name)) == 1
        assert np.abs(image - foggy[0])[hood].mean() < 12


def test_foggy_driving_is_complete(here: Path) -> None:
    root = HERE / "foggy_driving"
    pairs = foggy_driving.DATASET.tested(root, None, None)
    assert len(pairs) == 8
    for image, labels in pairs:
        ids = read_ids(root / labels)
        to_train_ids(ids, labels)
        assert read_rgb(root / image).shape[:2] == ids.shape
        assert (ids == 0).any() == ("gtCoarse" in labels)
    fine = (root / "lists_file_names/leftImg8bit_testfine_filenames.txt").read_text().split()
    assert sorted(fine) == [image for image, labels in pairs if "gtFine" in labels]


def test_list_files_are_named_as_the_real_ones(here: Path, real_data: Path) -> None:
    names = {path.name for path in (real_data / "foggy_driving_lists").glob("*.txt")}
    assert {path.name for path in (HERE / "foggy_driving/lists_file_names").iterdir()} == names


def test_foggy_zurich_is_complete(here: Path) -> None:
    root = HERE / "foggy_zurich"
    versions = (SimpleNamespace(zurich_list=version) for version in ("testv2", "testv1"))
    pairs, first = (foggy_zurich.DATASET.tested(root, None, version) for version in versions)
    assert (len(pairs), len(first)) == (5, 2)
    assert set(first) < set(pairs)
    for image, labels in pairs:
        assert read_rgb(root / image).shape == (36, 64, 3)
        train_ids = read_ids(root / labels.replace("gt_labelIds", "gt_labelTrainIds"))
        assert np.array_equal(check_train_ids(train_ids, labels), to_train_ids(read_ids(root / labels), labels))


def test_workers_and_repeats_make_the_same_bytes(here: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    scenes(small(), "synscapes", jobs=2)
    assert contents(HERE / "synscapes") == contents(here / HERE / "synscapes")
    assert contents(HERE / "index/synscapes") == contents(here / HERE / "index/synscapes")


def test_an_interrupted_run_keeps_the_frames_that_are_right(
    here: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    scenes(small(), "cityscapes")
    before = contents(HERE / "cityscapes")
    images = sorted((HERE / "cityscapes/leftImg8bit").rglob("*.png"))
    images[0].write_bytes(b"broken")
    images[1].unlink()
    kept = images[2].stat().st_mtime_ns
    extra = HERE / "cityscapes/leftImg8bit/train/aachen/.half.part"
    extra.write_bytes(b"")
    scenes(small(), "cityscapes")
    assert contents(HERE / "cityscapes") == before
    assert images[2].stat().st_mtime_ns == kept
    scenes(small(seed=1), "cityscapes")
    assert contents(HERE / "cityscapes").keys() == before.keys()
    assert not set(contents(HERE / "cityscapes/leftImg8bit").values()) & set(before.values())


def test_a_real_root_is_read_and_never_written(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    real = {name: tmp_path / f"real {name}" for name in DATASETS}
    for name, folder in real.items():
        shutil.copytree(made / HERE / name, folder)
    (real["synscapes"] / "meta/8.json").write_bytes((real["synscapes"] / "meta/7.json").read_bytes())
    for part, ending in (("rgb", "png"), ("depth", "exr"), ("class", "png")):
        shutil.copy(real["synscapes"] / f"img/{part}/7.{ending}", real["synscapes"] / f"img/{part}/8.{ending}")
    params = small(roots={name: str(folder) for name, folder in real.items()})
    before = {name: contents(folder) for name, folder in real.items()}
    for name, folder in real.items():
        scenes(params, name)
        assert contents(folder) == before[name]
        assert [path.name for path in (HERE / name).iterdir()] == ["README.txt"]
        record = (HERE / "index" / name / "run.json").read_text()
        assert str(tmp_path) not in record
    for name in real.keys() - {"synscapes"}:
        assert index_of(name).read_bytes() == (made / index_of(name)).read_bytes()


@pytest.mark.parametrize(
    ("dataset", "gone", "message"),
    [
        ("synscapes", "img/depth/3.exr", r"frame 3 lacks img/depth/3\.exr"),
        ("cityscapes", "gtFine/train/aachen/aachen_000001_000019_gtFine_labelIds.png", "labelIds.png: missing"),
        ("foggy_cityscapes", "foggy_trainval_refined_filenames.txt", "scenes.refined_list"),
        ("foggy_driving", "lists_file_names/gt_testall_filenames.txt", r"gt_testall_filenames\.txt: missing"),
        ("foggy_zurich", "RGB/GP010229/1508040913.0_frame_000010.png", "missing"),
    ],
)
def test_a_missing_file_is_named(
    dataset: str, gone: str, message: str, made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copytree(made / HERE / dataset, tmp_path / "real")
    (tmp_path / "real" / gone).unlink()
    with pytest.raises(FoggyError, match=message):
        scenes(small(roots={dataset: "real"}), dataset)
    assert not index_of(dataset).exists()


def test_wrong_calls_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UsageError, match="--jobs 0"):
        scenes(small(), "cityscapes", jobs=0)
    with pytest.raises(FoggyError, match=r"scenes\.roots\.cityscapes: nowhere is no folder"):
        scenes(small(roots={"cityscapes": "nowhere"}), "cityscapes")
    with pytest.raises(FoggyError, match="8 refined frames of 7 without a blue sky"):
        scenes(small(foggy_cityscapes={"train": 8, "val": 2}), "foggy_cityscapes")


def test_a_linked_folder_is_neither_written_to_nor_cleared(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    precious = tmp_path / "precious"
    precious.mkdir()
    (precious / "mine.txt").write_text("mine")
    HERE.mkdir(parents=True)
    (HERE / "foggy_zurich").symlink_to(precious)
    with pytest.raises(FoggyError, match="not written through a link"):
        scenes(small(), "foggy_zurich")
    assert [path.name for path in precious.iterdir()] == ["mine.txt"]
