"""Both engines wire the same steps: same commands, same outputs, same edges, same code."""

import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import pytest
from dvc.repo import Repo
from engines import in_plan

from foggy_synscapes import steps as table
from foggy_synscapes.jobs import Job
from foggy_synscapes.params import load
from foggy_synscapes.provenance.runs import code_of
from foggy_synscapes.results import CODE
from foggy_synscapes.stages.steps import dvc_yaml

ROOT = Path(__file__).resolve().parents[2]
# Folders that only DVC knows as outputs: it restores stand-in images from its cache, file by file.
FOLDERS = {"results/scenes"}


@dataclass(frozen=True)
class Step:
    """One job: what it reads and writes."""

    inputs: frozenset[str]
    outputs: frozenset[str]
    code: frozenset[str] = frozenset()


@pytest.fixture(scope="module")
def snakemake() -> dict[str, Step]:
    """Jobs of the Snakefile by their command."""
    call = [sys.executable, "-m", "snakemake", "--dry-run", "--forceall", "--printshellcmds", "--cores", "1"]
    # The profile of this project is quieter than what is read here.
    call += ["--workflow-profile", "none"]
    result = subprocess.run([*call, "--nolock"], cwd=ROOT, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    steps = {}
    for command, (inputs, outputs) in in_plan(result.stdout).items():
        # Trainings only wait for shards: their lists, which both engines see, hold the hash of each image.
        waited = {path for path in inputs if command.startswith("foggy train") and path.endswith(".tar")}
        steps[command] = Step(inputs - waited, outputs)
    return steps


@pytest.fixture(scope="module")
def dvc() -> dict[str, Step]:
    """Stages of dvc.yaml by their command."""
    steps = {}
    with Repo(str(ROOT)) as repo:
        for stage in repo.index.stages:
            paths = {dep.def_path for dep in stage.deps if not dep.def_path.endswith(".yaml")}
            code = frozenset(path for path in paths if is_below(path, CODE))
            steps[stage.cmd] = Step(paths - code, frozenset(out.def_path for out in stage.outs), code)
    # The stage that only writes what code means has no counterpart: Snakemake computes it when it plans.
    del steps["foggy code"]
    return steps


def is_below(path: str, folder: str) -> bool:
    return PurePosixPath(path).is_relative_to(folder)


def test_the_engines_run_the_same_commands(snakemake: dict[str, Step], dvc: dict[str, Step]) -> None:
    assert sorted(snakemake) == sorted(dvc)
    assert len(snakemake) > 50


def test_the_engines_write_the_same_files(snakemake: dict[str, Step], dvc: dict[str, Step]) -> None:
    for command, step in dvc.items():
        if any(is_below(path, folder) for path in step.outputs for folder in FOLDERS):
            assert all(any(is_below(path, folder) for folder in step.outputs) for path in snakemake[command].outputs)
        else:
            assert snakemake[command].outputs == step.outputs, command


def test_the_engines_read_the_same_files(snakemake: dict[str, Step], dvc: dict[str, Step]) -> None:
    for command, step in dvc.items():
        read = snakemake[command].inputs
        undeclared = [path for path in read if not any(is_below(path, dep) for dep in step.inputs)]
        assert not undeclared, f"dvc.yaml, `{command}`: deps lack {undeclared}"
        unused = [dep for dep in step.inputs if not any(is_below(path, dep) for path in read)]
        assert not unused, f"Snakefile, `{command}`: inputs lack {unused}"


def test_each_step_waits_for_the_same_steps(snakemake: dict[str, Step], dvc: dict[str, Step]) -> None:
    maker = {path: command for command, step in snakemake.items() for path in step.outputs}
    for command, step in dvc.items():
        ours = {maker[path] for path in snakemake[command].inputs if path in maker}
        theirs = {
            other
            for other, made in dvc.items()
            for out in made.outputs
            for dep in step.inputs
            if is_below(out, dep) or is_below(dep, out)
        }
        assert ours == theirs, command


def test_dvc_yaml_is_made_from_the_table_of_steps() -> None:
    assert dvc_yaml(load(ROOT / "params.yaml")) == (ROOT / "dvc.yaml").read_text(), "run `make dvc.yaml`"


def test_both_engines_compare_the_same_code(snakemake: dict[str, Step], dvc: dict[str, Step]) -> None:
    params = load(ROOT / "params.yaml")
    for step in table.steps():
        for values in step.all_values(params) if step.default else ():
            command = " ".join(Job(step, params, values).command)
            declared = {path for path in dvc[command].code if path.startswith(CODE)}
            assert declared == {table.code_file(step, values)}, command


# Packages below src/foggy_synscapes whose modules count for a word, with those of one of its jobs.
COUNTED = {
    "scenes": "camera datasets io labels scoring stages standin",
    "filter": "camera datasets io stages",
    "fog": "betas camera datasets depth fog frames io jit labels stages",
    "subset": "camera datasets io scoring stages subsets",
    "train": "datasets frames io labels networks stages training",
    "evaluate": "datasets io labels networks scoring stages",
    "tables": "datasets depth io labels networks scoring stages tables",
    "figures": "camera datasets figures fog io jit labels networks scoring stages training",
    "view": "betas camera datasets depth figures fog frames io jit labels networks scoring stages view",
    "stability": "camera datasets figures fog io jit labels networks scoring stability stages tables training",
}


@pytest.mark.parametrize("word", COUNTED)
def test_what_counts_for_each_word(word: str) -> None:
    params = load(ROOT / "params.yaml")
    found: set[str] = set()
    for step in table.of(word):
        for values in step.all_values(params):
            modules, _ = code_of(Job(step, params, values))
            found |= {re.split(r"[./]", name)[0] for name in modules}
    assert " ".join(sorted(found)) == COUNTED[word]


def test_training_a_network_does_not_hang_on_another() -> None:
    params = load(ROOT / "params.yaml")
    modules, libraries = code_of(table.job(params, "train", network="bisenet", row="C", seed="0"))
    assert not [name for name in modules if "refinenet" in name]
    assert not [name for name in modules if name.startswith(("fog", "frames.", "figures", "tables", "standin"))]
    assert "torch" in libraries


@pytest.mark.parametrize("name", ["cli", "params", "steps", "jobs", "provenance.runs", "errors", "registry", ""])
def test_the_chassis_counts_for_no_job(name: str) -> None:
    params = load(ROOT / "params.yaml")
    for step in table.steps():
        for values in step.all_values(params)[:1]:
            assert name not in code_of(Job(step, params, values))[0], step.name


def test_paths_of_results_are_written_in_the_table_alone() -> None:
    spelt = [
        path.relative_to(ROOT).as_posix()
        for folder in ("src", "workflow")
        for path in sorted((ROOT / folder).rglob("*"))
        if path.suffix in (".py", ".smk") and path.name not in ("steps.py", "results.py")
        if re.search(r"""["'(]results/[a-z]""", path.read_text(encoding="utf-8"))
    ]
    assert spelt == []
