"""What a job reads of the params is told to Snakemake, to DVC and in its run record: the same each time."""

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import yaml
from engines import VERBOSE, ran, run

from foggy_synscapes.params import Params
from foggy_synscapes.provenance.runs import leaves, read_runs, select

SMOKE = ("--params", "params/smoke.yaml")


def stated(values: Any) -> Any:
    """Leaves without null: a params file may leave out what is null, pydantic fills it in."""
    if isinstance(values, list):
        return [stated(value) for value in values]
    if isinstance(values, dict):
        return {key: stated(value) for key, value in leaves(values) if value is not None}
    return values


def recorded(folder: Path) -> dict[str, dict]:
    """Params in the run records, by command."""
    return {" ".join(record["command"]): stated(record["params"]) for record in read_runs(folder).values()}


def declared_to_snakemake(folder: Path) -> dict[str, dict]:
    """Params of the jobs that Snakemake ran, as it keeps them to see changes, by command."""
    found = {}
    for path in (folder / ".snakemake/metadata").rglob("*"):
        if path.is_file():
            job = json.loads(path.read_text())
            command = job["shellcmd"].partition(" > ")[0].removesuffix(" --params params/smoke.yaml")
            values = [json.loads(text[1:-1]) for text in job["params"] if text.startswith("'{")]
            (reads,) = [value for value in values if value and value.keys() <= Params.model_fields.keys()]
            found[command] = stated(reads)
    return found


def declared_to_dvc(folder: Path) -> dict[str, dict]:
    """Params of the stages that DVC ran, as it locked them, by command."""
    stages = yaml.safe_load((folder / "dvc.lock").read_text())["stages"]
    found = {}
    for stage in stages.values():
        if stage["cmd"] != "foggy code":
            found[stage["cmd"]] = nested(stage["params"]["params.yaml"])
    return found


def nested(values: dict[str, Any]) -> dict[str, Any]:
    """Values by dotted key, as the params file nests them."""
    tree: dict[str, Any] = {}
    for key, value in values.items():
        *outer, last = key.split(".")
        inner = tree
        for part in outer:
            inner = inner.setdefault(part, {})
        inner[last] = value
    return tree


def test_params_are_the_same_in_each_record_and_for_both_engines(snakemake: Path, dvc: Path) -> None:
    records, ours, theirs = recorded(snakemake / "results"), declared_to_snakemake(snakemake), declared_to_dvc(dvc)
    assert len(records) > 50
    assert records.keys() == ours.keys() == theirs.keys()
    for command, params in records.items():
        assert params, command
        assert ours[command] == params, f"Snakefile: {command}"
        same = stated(select(theirs[command], *params))
        assert same == params, f"dvc.yaml: {command}"


def test_dvc_is_told_no_more_than_a_job_reads(snakemake: Path, dvc: Path) -> None:
    for command, params in recorded(snakemake / "results").items():
        assert stated(declared_to_dvc(dvc)[command]).keys() == params.keys(), command


def test_scores_that_someone_altered_are_made_again_and_in_between_no_table_is_made_of_them(
    snakemake: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "clone"
    shutil.copytree(snakemake, folder)
    metrics = folder / "results/evaluate/foggy_zurich/bisenet/C/seed-0/metrics.json"
    made = metrics.read_bytes()
    scores = json.loads(made)
    scores["mean_iou"]["annotated"] = 99.0
    metrics.write_text(json.dumps(scores))
    call = [sys.executable, "-m", "foggy_synscapes", "tables", "--test-set", "foggy_zurich"]
    result = subprocess.run([*call, *SMOKE], cwd=folder, capture_output=True, text=True, check=False)
    assert result.returncode == 1
    assert f"{metrics.relative_to(folder)}: is not what its step wrote" in result.stderr
    assert "Make it again: foggy evaluate --network bisenet --row C --seed 0 --test-set foggy_zurich" in result.stderr
    told = run(folder, "snakemake", "--cores", "1", *VERBOSE, "--configfile", "params/smoke.yaml")
    assert ran(told) == {"evaluate bisenet C 0 foggy_zurich"}
    assert metrics.read_bytes() == made
    metrics.write_text(json.dumps(scores))
    table = folder / "results/tables/foggy_zurich.csv"
    table.unlink()
    told = run(folder, "snakemake", "--cores", "2", *VERBOSE, "--configfile", "params/smoke.yaml")
    assert ran(told) == {"evaluate bisenet C 0 foggy_zurich", "tables foggy_zurich"}  # the table waits for the scores
    assert metrics.read_bytes() == made
    assert table.read_bytes() == (snakemake / table.relative_to(folder)).read_bytes()
