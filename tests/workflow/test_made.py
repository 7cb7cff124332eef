"""Foggy Cityscapes made here from stereo, instead of the published one, through both engines."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import yaml
from engines import ROOT, clone, for_dvc, hashes, own_sources, run

from foggy_synscapes.io.images import read_rgb
from foggy_synscapes.io.plain_yaml import read_yaml
from foggy_synscapes.io.shards import Shard
from foggy_synscapes.io.tables import read_csv
from foggy_synscapes.params import load
from foggy_synscapes.steps import steps

PARAMS = "made.yaml"
LISTS = tuple(f"results/subset/FC-498/{part}.csv" for part in ("train", "validation"))


def small(folder: Path) -> None:
    """The overlay of made fog at the size of the smoke run: eight stereo frames in two shards."""
    stated, made = read_yaml(ROOT / "params/smoke.yaml"), read_yaml(ROOT / "params/made.yaml")
    stated["scenes"]["roots"] = made["scenes"]["roots"]
    stated["scenes"]["stand_in"]["cityscapes_stereo"] = {"train": 6, "val": 2}
    stated["complete"] = made["complete"] | {"shard_frames": 5, "superpixels": 32}
    stated["subset"] |= {"made": stated["subset"]["partial"], "partial": {}}
    (folder / PARAMS).write_text(yaml.safe_dump(stated))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """By engine, a clone in which it made the lists of the row; both at a time, for speed."""
    folders = {name: clone(tmp_path_factory.mktemp(f"made by {name}")) for name in ("snakemake", "dvc")}

    def by_snakemake() -> None:
        small(folders["snakemake"])
        run(folders["snakemake"], "snakemake", *LISTS, "--cores", "1", "--configfile", PARAMS)

    def by_dvc() -> None:
        small(folders["dvc"])
        folder = for_dvc(folders["dvc"], PARAMS)
        run(folder, "foggy_synscapes", "steps", "--dvc", "dvc.yaml", changes=own_sources(folder))
        run(folder, "dvc", "repro", "subset_made")

    with ThreadPoolExecutor() as pool:
        for started in [pool.submit(engine) for engine in (by_snakemake, by_dvc)]:
            started.result()
    return folders


def test_both_engines_make_the_same_fog_from_stereo(made: dict[str, Path]) -> None:
    ours, theirs = hashes(made["snakemake"]), hashes(made["dvc"])
    fog = {f"results/fog/cityscapes/beta_0.01/{shard}.tar" for shard in ("0000", "0001")}
    depth = {f"results/complete/{shard}/depth.tar" for shard in ("0000", "0001")}
    assert {*LISTS, *fog, *depth} <= {*theirs}
    assert {name: ours.get(name) for name in theirs} == theirs


def test_lists_take_the_images_that_were_made(made: dict[str, Path]) -> None:
    images = [row["image"] for part in LISTS for row in read_csv(made["snakemake"] / part)]
    assert len(images) == 8
    assert all(image.startswith("fog:cityscapes/beta_0.01/000") for image in images)


REAL = ("train", "dusseldorf", "dusseldorf_000020_000019")


@pytest.mark.parametrize("engine", ["snakemake", "dvc"])
def test_the_real_scene_comes_out_as_published(engine: str, real_data: Path, tmp_path: Path) -> None:
    reference = real_data / "stereo_reference/dusseldorf/foggy_gf_0p01.png"
    if not reference.is_file():
        pytest.skip(f"no results of the published stereo code at {reference}")
    folder = clone(tmp_path)
    small(folder)
    stated = read_yaml(folder / PARAMS)
    stated["scenes"]["roots"]["cityscapes_stereo"] = str(real_data / "cityscapes")
    stated["complete"] |= {"shards": ["0000"], "superpixels": 2048}
    (folder / PARAMS).write_text(yaml.safe_dump(stated))
    shard = folder / "results/fog/cityscapes/beta_0.01/0000.tar"
    if engine == "snakemake":
        run(folder, "snakemake", shard.relative_to(folder).as_posix(), "--cores", "1", "--configfile", PARAMS)
    else:
        for_dvc(folder, PARAMS)
        run(folder, "foggy_synscapes", "steps", "--dvc", "dvc.yaml", changes=own_sources(folder))
        run(folder, "dvc", "repro", "fog_made")
    name = f"leftImg8bit_foggy/{'/'.join(REAL)}_leftImg8bit_foggy_beta_0.01.png"
    with Shard(shard) as foggy:
        assert foggy.names() == [name]
        np.testing.assert_array_equal(read_rgb(foggy.read(name)), read_rgb(reference))


def test_nothing_is_completed_where_it_is_not_asked_for() -> None:
    params = load(ROOT / "params.yaml")
    assert not [step.name for step in steps() if step.word == "complete" and step.all_values(params)]
    assert "foggy complete" not in (ROOT / "dvc.yaml").read_text()
