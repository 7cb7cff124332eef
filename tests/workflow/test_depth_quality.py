"""The experiment on the quality of depth, through both engines: depth, fog, lists and the table of errors."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
import yaml
from engines import ROOT, clone, for_dvc, hashes, own_sources, run

from foggy_synscapes.io.plain_yaml import read_yaml
from foggy_synscapes.io.tables import read_csv
from foggy_synscapes.params import load
from foggy_synscapes.steps import steps

PARAMS = "depth_quality.yaml"
LISTS = tuple(f"results/subset/FS-498-completed/{part}.csv" for part in ("train", "validation"))
TABLE = "results/tables/depth_quality.csv"


def small(folder: Path) -> None:
    """The overlay at the size of the smoke run: ten frames in two shards."""
    stated, own = read_yaml(ROOT / "params/smoke.yaml"), read_yaml(ROOT / "params/depth_quality.yaml")
    stated["stereo"] = own["stereo"] | {"superpixels": 32}
    stated["subset"]["completed"] = {"FS-498-completed": dict(stated["subset"]["pure"]["FS-498"])}
    stated["train"]["from_baseline"].append("FS-498-completed")
    stated["train"]["rows"]["FS-498-completed"] = read_yaml(ROOT / "params/smoke.yaml")["train"]["rows"]["FS-498"]
    (folder / PARAMS).write_text(yaml.safe_dump(stated))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """By engine, a clone in which it made the lists and the table; both at a time, for speed."""
    folders = {name: clone(tmp_path_factory.mktemp(f"depth by {name}")) for name in ("snakemake", "dvc")}

    def by_snakemake() -> None:
        small(folders["snakemake"])
        run(folders["snakemake"], "snakemake", *LISTS, TABLE, "--cores", "1", "--configfile", PARAMS)

    def by_dvc() -> None:
        small(folders["dvc"])
        folder = for_dvc(folders["dvc"], PARAMS)
        run(folder, "foggy_synscapes", "steps", "--dvc", "dvc.yaml", changes=own_sources(folder))
        run(folder, "dvc", "repro", "subset_completed", "tables_depth")

    with ThreadPoolExecutor() as pool:
        for started in [pool.submit(engine) for engine in (by_snakemake, by_dvc)]:
            started.result()
    return folders


def test_both_engines_make_the_same_fog_of_completed_depth(made: dict[str, Path]) -> None:
    ours, theirs = hashes(made["snakemake"]), hashes(made["dvc"])
    fog = {
        f"results/fog/completed/beta_0.005/{shard}.{kind}" for shard in ("0000", "0001") for kind in ("tar", "errors")
    }
    depth = {f"results/complete/synscapes/{shard}/depth.tar" for shard in ("0000", "0001")}
    assert {*LISTS, TABLE, *fog, *depth} <= {*theirs}
    assert {name: ours.get(name) for name in theirs} == theirs


def test_errors_grow_with_distance(made: dict[str, Path]) -> None:
    lines = {line["group"]: float(line["depth_percent"]) for line in read_csv(made["snakemake"] / TABLE)}
    assert lines["0 to 25 m"] < lines["25 to 50 m"] < lines["beyond 200 m"]


def test_no_stereo_camera_is_simulated_where_it_is_not_asked_for() -> None:
    params = load(ROOT / "params.yaml")
    asked = [step.name for step in steps() if step.asked == "stereo" and step.all_values(params)]
    assert asked == []
    assert "synscapes-shard" not in (ROOT / "dvc.yaml").read_text()
