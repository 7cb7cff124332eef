"""Planning at the counts of the paper: jobs, what each asks of a cluster, and results that a remote shares."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest
import scale
from dvc.utils.hydra import apply_overrides
from engines import ROOT, clone, hashes, ran, run

from foggy_synscapes.params import load

FRAMES = 1000  # two shards of 500


@pytest.fixture(scope="module")
def plan(tmp_path_factory: pytest.TempPathFactory) -> str:
    """What a dry run by the Slurm profile says of five betas over a fake Synscapes, indexed but without results."""
    folder = clone(tmp_path_factory.mktemp("plan"))
    scale.plan(folder, FRAMES)
    run(folder, "foggy_synscapes", "scenes", "--dataset", "synscapes", "--params", "params/scale.yaml")
    profiles = ("--profile", "workflow/profiles/slurm", "--workflow-profile", "none")
    return run(folder, "snakemake", *profiles, "--dry-run", "--printshellcmds", "--configfile", "params/scale.yaml")


def asked(plan: str, rule: str) -> list[dict[str, str]]:
    """Resources of the planned jobs of a rule."""
    lines = re.findall(rf"^rule {rule}:\n(?:    .*\n)*?    resources: (.*)$", plan, re.MULTILINE)
    return [dict(part.split("=", 1) for part in line.split(", ")) for line in lines]


def test_fog_is_planned_by_shard_and_beta_not_by_image(plan: str) -> None:
    assert len(asked(plan, "fog_each")) == 2 * len(scale.BETAS)
    assert len(asked(plan, "fog_airlight")) == 2


def test_every_job_says_how_much_memory_and_time_it_wants(plan: str) -> None:
    jobs = [name for name in re.findall(r"^rule (\S+):$", plan, re.MULTILINE) if name != "all"]
    assert len(jobs) > 100
    for name in set(jobs):
        for wanted in asked(plan, name):
            assert int(wanted["mem_mb"]) >= 1000, name
            assert int(wanted["runtime"]) >= 30, name


def test_training_asks_for_a_gpu_where_the_params_say_cuda_and_fog_never_does(plan: str) -> None:
    assert asked(plan, "train_from_baseline")[0]["gpu"] == "1"
    assert asked(plan, "train_from_weights")[0]["gpu"] == "1"
    assert "gpu" not in asked(plan, "fog_each")[0]


def test_only_snakemake_submits_a_lost_job_again(plan: str) -> None:
    assert asked(plan, "fog_each")[0]["slurm_extra"].strip("'") == "--no-requeue"


def test_a_clone_that_pulls_has_nothing_to_do(dvc: Path, tmp_path: Path) -> None:
    run(dvc, "dvc", "remote", "add", "--force", "--local", "store", str(tmp_path / "store"))
    run(dvc, "dvc", "push", "--run-cache", "--remote", "store")
    folder = clone(tmp_path / "clone")
    for name in ("params.yaml", "dvc.lock", ".dvc/config.local"):
        shutil.copy(dvc / name, folder / name)
    subprocess.run(["git", "init", "--quiet"], cwd=folder, check=True)
    run(folder, "dvc", "pull", "--remote", "store")
    assert hashes(folder) == hashes(dvc)
    # What code means is no result, and is written anew.
    assert ran(run(folder, "dvc", "repro")) == {"code"}


def test_another_clone_reuses_fogged_shards_by_the_run_cache(dvc: Path, tmp_path: Path) -> None:
    run(dvc, "dvc", "remote", "add", "--force", "--local", "store", str(tmp_path / "store"))
    run(dvc, "dvc", "push", "--run-cache", "--remote", "store")
    folder = clone(tmp_path / "clone")
    for name in ("params.yaml", ".dvc/config.local"):
        shutil.copy(dvc / name, folder / name)
    subprocess.run(["git", "init", "--quiet"], cwd=folder, check=True)
    run(folder, "dvc", "remote", "default", "--local", "store")
    run(folder, "dvc", "fetch", "--run-cache")
    told = run(folder, "dvc", "repro", "--pull", "fog@0.005-0000")
    assert "Stage 'fog@0.005-0000' is cached" in told
    assert ran(told) == {"code"}


def test_the_documented_experiment_with_another_beta_passes_the_params(tmp_path: Path) -> None:
    changes = re.findall(r'-S "([^"]+)"', (ROOT / "docs/scale.md").read_text())
    shutil.copy(ROOT / "params.yaml", tmp_path / "params.yaml")
    apply_overrides(str(tmp_path / "params.yaml"), changes)
    changed = load(tmp_path / "params.yaml")
    assert changed.fog.betas == ["0.01"] != load(ROOT / "params.yaml").fog.betas
