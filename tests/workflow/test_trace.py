"""From a table, and from one of its cells, down to the raw data; what on disk no longer matches is flagged."""

import json
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from engines import run
from rocrate.rocrate import ROCrate

from foggy_synscapes.io.hashing import sha256
from foggy_synscapes.provenance.runs import leaves

TABLE = "results/tables/foggy_zurich.tex"
SMOKE = ("--params", "params/smoke.yaml")


def trace(folder: Path, *arguments: str) -> str:
    return run(folder, "foggy_synscapes", "trace", *arguments, *SMOKE)


def nodes(node: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """A node and all below it."""
    yield node
    for child in node.get("inputs", ()):
        yield from nodes(child)


def test_a_table_leads_down_to_the_raw_data_of_every_dataset_that_it_needs(snakemake: Path) -> None:
    tree = json.loads(trace(snakemake, TABLE, "--json"))
    found = list(nodes(tree))
    assert {node["command"].split()[1] for node in found} == {
        "tables", "evaluate", "train", "subset", "fog", "filter", "scenes"
    }  # fmt: skip
    assert {Path(node["raw"]["folder"]).name for node in found if "raw" in node} == {
        "synscapes", "cityscapes", "foggy_cityscapes", "foggy_zurich"
    }  # fmt: skip
    assert all(node["state"] == "unchanged" for node in found)
    assert all(node["sha256"] == sha256(snakemake / node["path"]) for node in found)
    jobs = [node for node in found if "params" in node]
    assert all(node["code"] and not node["code_changed"] and node["versions"] and node["params"] for node in jobs)
    assert len({node["record"] for node in found}) == len(jobs)
    raw = [node["raw"] for node in found if "raw" in node]
    assert all(listing["files"] and not listing["missing"] and not listing["changed"] for listing in raw)


def test_the_text_says_the_same_and_marks_nothing(snakemake: Path) -> None:
    text = trace(snakemake, TABLE)
    assert text.startswith(f"{TABLE}  {sha256(snakemake / TABLE)[:12]}\n  by: foggy tables --test-set foggy_zurich\n")
    assert "foggy scenes --dataset synscapes" in text
    assert "files below results/scenes/synscapes" in text
    assert "<--" not in text


def test_depth_cuts_the_tree_after_so_many_jobs(snakemake: Path) -> None:
    assert "inputs" not in json.loads(trace(snakemake, TABLE, "--json", "--depth", "0"))
    tree = json.loads(trace(snakemake, TABLE, "--json", "--depth", "1"))
    assert len(tree["inputs"]) == 10
    assert all("inputs" not in node and node["below"] == 2 for node in tree["inputs"])


def test_what_was_altered_is_flagged_from_raw_data_to_code(snakemake: Path, tmp_path: Path) -> None:
    folder = tmp_path / "clone"
    shutil.copytree(snakemake / "results", folder / "results")
    shutil.copytree(snakemake / "params", folder / "params")
    metrics = "results/evaluate/foggy_zurich/bisenet/C/seed-0/metrics.json"
    (folder / metrics).write_text("{}")
    depth = folder / "results/scenes/synscapes/img/depth/3.exr"
    depth.write_bytes(depth.read_bytes() + b" ")
    (folder / "results/subset/C/train.csv").unlink()
    record = folder / "results/filter/run.json"
    document = json.loads(record.read_text())
    document["code"]["stages/filter.py"] = "0" * 64
    record.write_text(json.dumps(document))
    lines = trace(folder, TABLE).splitlines()
    marked = {line.split("  <-- ")[0].split()[0]: line.partition("<-- ")[2] for line in lines if "<--" in line}
    assert marked[metrics] == "Changed"
    assert marked["results/subset/C/train.csv"] == "Missing"
    assert marked["lists"] == "Changed: results/scenes/synscapes/img/depth/3.exr"
    assert marked["code:"] == "Changed since: stages/filter.py"
    assert len(marked) == 4


def test_a_cell_leads_to_its_model_its_lists_and_its_images(snakemake: Path) -> None:
    chosen = ("RefineNet", "FC-FS-498", "vegetation", "--test-set", "foggy_zurich")
    cell = json.loads(trace(snakemake, "--cell", *chosen, "--json"))
    assert (cell["test_set"], cell["network"], cell["row"], cell["score"]) == (
        "foggy_zurich", "RefineNet", "FC-FS-498", "vegetation"
    )  # fmt: skip
    (seed,) = cell["runs"]
    scores = json.loads((snakemake / seed["metrics"]["path"]).read_text())
    entry = next(entry for entry in scores["classes"] if entry["name"] == "vegetation")
    assert cell["value"] == seed["value"] == entry["iou"]
    assert seed["counts"] == {key: entry[key] for key in ("tp", "fp", "fn")}
    assert seed["table_agrees"]
    assert len(seed["predictions"]["images"]) == scores["images"]
    model = seed["model"]
    assert model["path"] == "results/train/refinenet/FC-FS-498/seed-0/model.safetensors"
    assert model["start"]["path"] == "results/train/refinenet/C/seed-0/model.safetensors"
    train = model["lists"][0]
    assert train["count"] == 9
    assert [(source["path"], len(source["images"])) for source in train["sources"]] == [
        ("results/fog/beta_0.005/0000.tar", 6),
        ("foggy_cityscapes", 3),
    ]
    assert train["sources"][0]["sha256"] == sha256(snakemake / "results/fog/beta_0.005/0000.tar")
    assert train["sources"][0]["images"][0]["image"] == "00001_beta_0.005.png"
    assert [source["path"] for source in model["start"]["lists"][0]["sources"]] == ["cityscapes"]


def test_a_cell_in_text_tells_what_is_printed(snakemake: Path) -> None:
    text = trace(snakemake, "--cell", "bisenet", "FS-498", "mean IoU annotated", "--test-set", "foggy_driving")
    printed = (snakemake / "results/tables/foggy_driving.md").read_text().splitlines()
    line = next(line for line in printed if line.startswith("| BiSeNet | C | FS (498"))
    value = line.split("|")[-3].strip().strip("*")
    assert text.startswith(f"foggy_driving, BiSeNet, FS-498, mean IoU annotated: {value} (")
    assert "6 images: 00001_beta_0.005.png" in text
    assert "<--" not in text


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--cell", "RefineNet", "FS-498", "skye"], "scores are road, sidewalk"),
        (["--cell", "SegNet", "FS-498", "sky"], "networks are RefineNet, BiSeNet"),
        (["--cell", "RefineNet", "FS-499", "sky"], "has the rows C, FC-498"),
        (["--cell", "RefineNet", "C-control", "sky"], "was not run; its cells are --"),
        (["results/tables/none.tex"], "no run record has it among its outputs"),
        ([], "give a result"),
        ([TABLE, "--depth", "-1"], "expected 0 or more"),
    ],
)
def test_what_is_not_there_is_said(snakemake: Path, arguments: list[str], message: str) -> None:
    call = [sys.executable, "-m", "foggy_synscapes", "trace", *arguments, *SMOKE]
    result = subprocess.run(call, cwd=snakemake, capture_output=True, text=True, check=False)
    assert result.returncode in (1, 2)
    assert message in result.stderr
    assert "Traceback" not in result.stderr


@pytest.mark.parametrize("form", [[], ["--json"]])
def test_a_reader_that_has_seen_enough_ends_it_quietly(snakemake: Path, form: list[str]) -> None:
    call = [sys.executable, "-m", "foggy_synscapes", "trace", TABLE, *SMOKE, *form]
    with subprocess.Popen(call, cwd=snakemake, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 0


def test_a_crate_holds_the_files_jobs_params_and_versions_behind_a_table(snakemake: Path, tmp_path: Path) -> None:
    """What Workflow Run Crate 0.5 requires, read by the library that others read crates with."""
    for name in ("one.zip", "two.zip", "folder"):
        trace(snakemake, TABLE, "--crate", str(tmp_path / name), "--date", "2026-11-24")
    assert sha256(tmp_path / "one.zip") == sha256(tmp_path / "two.zip")
    crate = ROCrate(tmp_path / "folder")
    assert crate.datePublished.date().isoformat() == "2026-11-24"
    profiles = {entity.id for entity in crate.root_dataset["conformsTo"]}
    assert "https://w3id.org/ro/wfrun/workflow/0.5" in profiles
    assert crate.mainEntity.id == "Snakefile"
    assert set(crate.mainEntity.type) == {"File", "SoftwareSourceCode", "ComputationalWorkflow"}
    whole, *actions = crate.root_dataset["mentions"]
    assert whole["instrument"] == crate.mainEntity
    jobs = {node["record"]: node for node in nodes(json.loads(trace(snakemake, TABLE, "--json"))) if "params" in node}
    assert {action.id.removeprefix("#") for action in actions} == jobs.keys()
    for action in actions:
        node = jobs[action.id.removeprefix("#")]
        assert action["name"] == node["command"]
        assert action["instrument"]["softwareVersion"]
        values = {entity["name"] for entity in action["object"] if entity.type == "PropertyValue"}
        assert values >= dict(leaves(node["params"])).keys()
        hashes = {entity["sha256"] for entity in action["object"] if entity.type != "PropertyValue"}
        assert hashes == {each["sha256"] for each in node["inputs"]}
    files = [entity for entity in crate.data_entities if "sha256" in entity.properties()]
    assert TABLE in {entity.id for entity in files}
    assert all(sha256(tmp_path / "folder" / entity.id) == entity["sha256"] for entity in files)
    assert str(snakemake) not in (tmp_path / "folder/ro-crate-metadata.json").read_text()


def test_a_crate_of_what_was_altered_is_refused(snakemake: Path, tmp_path: Path) -> None:
    folder = tmp_path / "clone"
    shutil.copytree(snakemake / "results", folder / "results")
    for name in ("params", "Snakefile"):
        (folder / name).symlink_to(snakemake / name)
    (folder / TABLE).write_text("better")
    call = [sys.executable, "-m", "foggy_synscapes", "trace", TABLE, *SMOKE, "--crate", "crate.zip"]
    result = subprocess.run(call, cwd=folder, capture_output=True, text=True, check=False)
    assert result.returncode == 1
    assert f"{TABLE}: changed; a crate tells of what is as recorded" in result.stderr
    assert not (folder / "crate.zip").exists()
