"""Fog from stereo as jobs of the pipeline: depth, foggy images, lists, records, resumption."""

import json
from pathlib import Path

import numpy as np
import pytest
from fog_frames import tree
from records import index_of, vouch
from stereo_frames import NAMES, SIZE, content, write_all

from foggy_synscapes.camera import Camera
from foggy_synscapes.datasets import cityscapes
from foggy_synscapes.datasets.index import write_index
from foggy_synscapes.datasets.uris import Reader
from foggy_synscapes.depth import annotation, refinement
from foggy_synscapes.depth.completion import Stereo
from foggy_synscapes.depth.completion import complete as completed
from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.fog.airlight import estimate
from foggy_synscapes.fog.geometry import rays
from foggy_synscapes.io.arrays import read_npz
from foggy_synscapes.io.atomic import write_bytes
from foggy_synscapes.io.images import encode_png, read_rgb
from foggy_synscapes.io.plain_yaml import read_yaml
from foggy_synscapes.io.shards import Shard, read_manifest
from foggy_synscapes.io.tables import read_csv
from foggy_synscapes.params import Params, check, load
from foggy_synscapes.stages import fog as fog_stage
from foggy_synscapes.stages.complete import complete
from foggy_synscapes.stages.scenes import scenes
from foggy_synscapes.stages.subset import subset
from foggy_synscapes.steps import job

ROOT = Path(__file__).resolve().parents[2]
CAMERA = Camera(350.0, 350.0, 161.0, 99.0, SIZE[1], SIZE[0])
SUPERPIXELS = 256
FOGGY = Path("results/fog/cityscapes/beta_0.02")


@pytest.fixture(scope="module")
def raw(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = write_all(tmp_path_factory.mktemp("stereo") / "cityscapes")
    for name in NAMES:
        write_bytes(root / cityscapes.labels(name), encode_png(np.zeros(SIZE, np.uint8)))
    return root


def made(raw: Path, **changes: object) -> Params:
    """Three stereo frames in two shards, and one list of them."""
    document = read_yaml(ROOT / "params.yaml")
    document["scenes"]["roots"] |= {"cityscapes": str(raw), "cityscapes_stereo": str(raw)}
    document["complete"] = {
        "shard_frames": 2,
        "shards": ["0000", "0001"],
        "betas": ["0.02"],
        "refine": "guided",
        "superpixels": SUPERPIXELS,
        "seed": 5489,
    } | changes
    document["subset"] |= {"partial": {}, "made": {"FC-498": {"beta": "0.02", "train": 2, "validation": 1}}}
    return check(document, "params.yaml")


@pytest.fixture
def params(raw: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Params:
    monkeypatch.chdir(tmp_path)
    found = made(raw)
    scenes(found, "cityscapes_stereo")
    labels = [cityscapes.labels(name) for name in NAMES]
    write_index(index_of("cityscapes"), raw, [*map(cityscapes.image, NAMES), *labels])
    vouch(index_of("cityscapes"))
    return found


def run(params: Params) -> None:
    for shard in ("0000", "0001"):
        complete(params, shard)
        fog_stage.fog_made(params, "0.02", shard)


def expected(seed: int, bilateral: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Depth and fog of a frame."""
    arrays = content(seed)
    left, stereo = arrays["left"], Stereo(CAMERA, 0.22)
    depth = completed(left, arrays["right"], arrays["disparity"], stereo, wanted=SUPERPIXELS).depth
    labels = annotation.labels(arrays["ids"])
    refine = refinement.bilateral(left, labels) if bilateral else refinement.guided(left)
    values = refine(refinement.initial(depth, rays(CAMERA), 0.02))
    return depth, refinement.composite(left, values, estimate(left).levels)


def test_shards_hold_depth_and_fog_of_their_frames(params: Params) -> None:
    run(params)
    for shard, seeds in (("0000", (0, 1)), ("0001", (2,))):
        with Shard(f"results/complete/{shard}/depth.tar") as depth, Shard(FOGGY / f"{shard}.tar") as foggy:
            assert depth.names() == [f"{NAMES[seed]}_depth.npz" for seed in seeds]
            assert foggy.names() == [
                f"leftImg8bit_foggy/{NAMES[seed]}_leftImg8bit_foggy_beta_0.02.png" for seed in seeds
            ]
            for seed, depth_name, foggy_name in zip(seeds, depth.names(), foggy.names(), strict=True):
                metres, image = expected(seed)
                np.testing.assert_array_equal(read_npz(depth.read(depth_name), "depth"), metres)
                np.testing.assert_array_equal(read_rgb(foggy.read(foggy_name)), image)
        assert [row["id"] for row in read_csv(Path(f"results/complete/{shard}/airlight.csv"))] == [
            NAMES[seed] for seed in seeds
        ]
        assert [member.name for member in read_manifest(FOGGY / f"{shard}.csv")] == foggy.names()


def test_the_bilateral_filter_is_a_choice_of_the_params(params: Params, raw: Path) -> None:
    params = made(raw, refine="bilateral")
    complete(params, "0001")
    fog_stage.fog_made(params, "0.02", "0001")
    with Shard(FOGGY / "0001.tar") as foggy:
        (name,) = foggy.names()
        assert name.startswith("leftImg8bit_foggyDBF/val/lindau/")
        np.testing.assert_array_equal(read_rgb(foggy.read(name)), expected(2, bilateral=True)[1])


def test_lists_name_images_that_training_can_read(params: Params, raw: Path) -> None:
    run(params)
    subset(params, "FC-498")
    reader = Reader({"cityscapes": raw}, "results/fog")
    for part, seeds in (("train", (0, 1)), ("validation", (2,))):
        rows = read_csv(Path(f"results/subset/FC-498/{part}.csv"))
        assert len(rows) == len(seeds)
        for row, seed in zip(rows, seeds, strict=True):
            image = read_rgb(reader.read(row["image"], row["image_sha256"]), row["image"])
            np.testing.assert_array_equal(image, expected(seed)[1])
            assert row["label"] == f"cityscapes:{cityscapes.labels(NAMES[seed])}"
            assert reader.read(row["label"], row["label_sha256"])


def test_a_training_waits_for_the_shards_of_its_list(params: Params) -> None:
    training = job(params, "train", network="bisenet", row="FC-498", seed="0")
    assert training.step.waits is not None
    assert [*training.step.waits(params, training.values)] == [f"{FOGGY}/0000.tar", f"{FOGGY}/0001.tar"]


def test_records_say_what_was_made_from_what(params: Params) -> None:
    run(params)
    record = json.loads(Path("results/complete/0001/run.json").read_text())
    assert record["command"] == ["foggy", "complete", "--shard", "0001"]
    assert [*record["inputs"]] == ["results/scenes/index/cityscapes_stereo/all.csv"]
    assert record["params"]["complete"]["seed"] == 5489
    assert {"depth.kernels.planes", "depth.kernels.twister"} <= {*record["code"]}
    foggy = json.loads((FOGGY / "0001.run.json").read_text())
    assert foggy["command"] == ["foggy", "fog", "--beta", "0.02", "--stereo", "0001"]
    assert {"results/complete/0001/depth.tar", "results/complete/0001/airlight.csv"} <= {*foggy["inputs"]}
    assert "depth.kernels.guided" in foggy["code"]


def test_an_interrupted_job_goes_on_to_the_same_bytes(params: Params, monkeypatch: pytest.MonkeyPatch) -> None:
    run(params)
    before = tree(Path("results"))
    made_again = []
    from foggy_synscapes.frames import stereo

    whole = stereo.completed

    def stops(*args: object) -> object:
        made_again.append(args)
        if len(made_again) == 2:
            raise KeyboardInterrupt
        return whole(*args)

    monkeypatch.setattr(stereo, "completed", stops)
    for path in ("depth.tar", "depth.csv", "airlight.csv", "run.json"):
        Path("results/complete/0000", path).unlink()
    with pytest.raises(KeyboardInterrupt):
        complete(params, "0000")
    assert not Path("results/complete/0000/depth.tar").exists()
    complete(params, "0000")
    assert len(made_again) == 3  # the first frame was kept
    assert tree(Path("results")) == before


def test_another_seed_begins_anew(params: Params, raw: Path) -> None:
    complete(params, "0001")
    before = Path("results/complete/0001/depth.tar").read_bytes()
    complete(made(raw, seed=1), "0001")
    assert Path("results/complete/0001/depth.tar").read_bytes() != before


def test_shards_that_the_frames_do_not_fill_are_refused(params: Params, raw: Path) -> None:
    with pytest.raises(FoggyError, match="3 frames in shards of 3 are 1 shards, got 2"):
        complete(made(raw, shard_frames=3), "0000")


def test_jobs_that_there_are_not_are_refused(params: Params) -> None:
    with pytest.raises(UsageError, match=r"--shard 0009: not in complete\.shards, which has 0000, 0001"):
        complete(params, "0009")
    with pytest.raises(UsageError, match=r"--stereo 0000 --beta 0\.01: not in the params section complete"):
        fog_stage.fog_made(params, "0.01", "0000")
    with pytest.raises(UsageError, match="there is no section complete"):
        complete(load(ROOT / "params.yaml"), "0000")


def test_a_file_that_is_not_as_indexed_is_refused(params: Params, raw: Path) -> None:
    path = raw / cityscapes.right(NAMES[2])
    before = path.read_bytes()
    try:
        path.write_bytes(encode_png(content(0)["right"]))
        with pytest.raises(FoggyError, match="rightImg8bit"):
            complete(params, "0001")
    finally:
        path.write_bytes(before)


def test_betas_that_no_list_asks_for_are_refused(raw: Path) -> None:
    with pytest.raises(FoggyError, match=r"complete.betas: has 0.01, 0.02, but the lists .* ask for 0.02"):
        made(raw, betas=["0.01", "0.02"])
    with pytest.raises(FoggyError, match="complete: shards: expected the names 0000 to 0000"):
        made(raw, shards=["0001"])


def test_the_overlay_of_made_fog_changes_nothing_of_other_rows() -> None:
    plain, overlay = load(ROOT / "params.yaml"), load(ROOT / "params/made.yaml")
    assert overlay.fog == plain.fog
    assert overlay.train == plain.train
    assert overlay.tables == plain.tables
    assert {**overlay.subset.partial, **overlay.subset.made_here()}.keys() == plain.subset.partial.keys()
