"""Both engines wire the same steps: same commands, same outputs, same edges; and each step declares what it imports."""

import importlib.util
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import pytest
from dvc.repo import Repo

from foggy_synscapes.provenance import source_digest

ROOT = Path(__file__).resolve().parents[2]
# Folders that only DVC knows as outputs: it restores stand-in images from its cache, file by file.
FOLDERS = {"results/scenes"}


@dataclass(frozen=True)
class Step:
    """One job: what it reads and writes."""

    inputs: frozenset[str]
    outputs: frozenset[str]


@pytest.fixture(scope="module")
def snakemake() -> dict[str, Step]:
    """Jobs of the Snakefile by their command."""
    call = [sys.executable, "-m", "snakemake", "--dry-run", "--forceall", "--printshellcmds", "--cores", "1"]
    # The profile of this project is quieter than what is read here.
    call += ["--workflow-profile", "none"]
    result = subprocess.run([*call, "--nolock"], cwd=ROOT, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    steps = {}
    for block in re.split(r"\n(?=(?:local)?rule )", result.stdout):
        command = re.search(r"^Shell command: (foggy .*?)(?= > )", block, re.MULTILINE)
        if command:
            paths = {
                name: frozenset(re.search(rf"^ +{name}: (.*)$", block, re.MULTILINE)[1].split(", "))
                for name in ("input", "output")
            }
            # Trainings only wait for shards: their lists, which both engines see, hold the hash of each image.
            waited = {path for path in paths["input"] if command[1].startswith("foggy train") and path.endswith(".tar")}
            steps[command[1]] = Step(paths["input"] - waited, paths["output"])
    return steps


@pytest.fixture(scope="module")
def dvc() -> dict[str, Step]:
    """Stages of dvc.yaml by their command."""
    steps = {}
    with Repo(str(ROOT)) as repo:
        for stage in repo.index.stages:
            inputs = {dep.def_path for dep in stage.deps if not dep.def_path.endswith(".yaml")}
            steps[stage.cmd] = Step(frozenset(inputs), frozenset(out.def_path for out in stage.outs))
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


def test_each_step_declares_every_source_file_that_it_imports(dvc: dict[str, Step]) -> None:
    for command, step in dvc.items():
        declared = {path.removeprefix("src/foggy_synscapes/") for path in step.inputs if path.startswith("src/")}
        needed = set(source_digest.sources(command.split()[1]))
        assert declared == needed, f"`{command}`: add {sorted(needed - declared)}, remove {sorted(declared - needed)}"


def test_each_step_declares_the_locked_versions_of_its_libraries() -> None:
    spec = importlib.util.spec_from_file_location("declare_sources", ROOT / "workflow/declare_sources.py")
    declare_sources = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(declare_sources)
    made = declare_sources.versions((ROOT / "requirements.lock").read_text())
    assert made == (ROOT / "workflow/versions.yaml").read_text(), "run `make sources`"


def test_an_edit_of_the_fog_core_leaves_the_filter_alone() -> None:
    assert not [path for path in source_digest.sources("filter") if path.startswith("fog/")]
    assert [path for path in source_digest.sources("fog") if path.startswith("fog/")]


@pytest.mark.parametrize("word", ["scenes", "filter", "fog", "subset", "tables", "figures"])
def test_steps_without_a_network_do_not_import_torch(word: str) -> None:
    assert "torch" not in source_digest.libraries(word)


def test_imports_run_downwards_only() -> None:
    cores = ("fog", "inference", "networks", "training", "scoring", "scenes", "tabling", "plotting", "weighing")
    for path in sorted((ROOT / "src/foggy_synscapes").rglob("*.py")):
        room = path.relative_to(ROOT / "src/foggy_synscapes").parts[0]
        text = path.read_text(encoding="utf-8")
        imported = set(re.findall(r"^\s*(?:from|import) foggy_synscapes\.(\w+)", text, re.MULTILINE))
        if room in cores:
            assert not imported & {"io", "stages", "cli", "params"}, path
        if room in ("io", "datasets", "stages"):
            assert "cli" not in imported, path
            assert "stages" not in imported, path
        if room == "io":
            assert not imported & {*cores, "datasets"}, path
