"""`foggy plan` counts the jobs that the engines count, and a job that fails says why on the terminal."""

import json
import resource
import subprocess
from collections import Counter
from collections.abc import Iterable
from functools import cache
from pathlib import Path

import pytest
from dvc.repo import Repo
from engines import PLAN, clone, environment, for_dvc, in_plan, own_sources, run

PARAMS = ("params/smoke.yaml", "params/paper.yaml")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return clone(tmp_path_factory.mktemp("plan") / "clone")


@cache
def plan(folder: Path, params: str, *targets: str) -> dict:
    call = ["foggy", "plan", "--params", params, "--json", *targets]
    result = subprocess.run(
        call, cwd=folder, env=environment(own_sources(folder)), capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stderr
    return json.loads(result.stdout)


@cache
def snakemakes(folder: Path, params: str, target: str) -> list[str]:
    """Commands of the jobs that Snakemake plans."""
    told = run(folder, "snakemake", target, *PLAN, "--configfile", params, changes=own_sources(folder))
    return [command.partition(" --params")[0] for command in in_plan(told)]


def words(commands: Iterable[str]) -> dict[str, int]:
    """Number of commands by word; `foggy code` only tells DVC what code means."""
    found = Counter(command.split()[1] for command in commands)
    del found["code"]
    return dict(found)


@pytest.mark.parametrize("params", PARAMS)
@pytest.mark.parametrize("target", ["all", "paper"])
def test_snakemake_plans_as_many_jobs_of_each_word(folder: Path, params: str, target: str) -> None:
    assert plan(folder, params, target)["jobs"] == words(snakemakes(folder, params, target))


@pytest.mark.parametrize("params", PARAMS)
def test_dvc_has_as_many_stages_of_each_word(folder: Path, params: str) -> None:
    for_dvc(folder, params)
    with Repo(str(folder)) as repo:
        stages = words(stage.cmd for stage in repo.index.stages)
    assert plan(folder, params, "all")["jobs"] == stages


def test_the_papers_tables_need_nothing_that_the_paper_does_not_have(folder: Path) -> None:
    commands = snakemakes(folder, "params/paper.yaml", "paper")
    for absent in ("C-control", "FS-ImageNet", "FC-FS-24500", "--test-set cityscapes", "foggy figures", "foggy stab"):
        assert not [command for command in commands if absent in command], absent
    tables = sorted(command for command in commands if command.startswith("foggy tables"))
    assert tables == [f"foggy tables --test-set {name} --paper" for name in ("foggy_driving", "foggy_zurich")]


def test_the_papers_plan_takes_less_than_15_seconds(folder: Path) -> None:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    plan.__wrapped__(folder, "params/paper.yaml")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    # Of CPU time: on the clock it hangs on what else the machine does.
    assert after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime < 15


@pytest.mark.parametrize("profile", [(), ("--workflow-profile", "none")])
def test_a_failed_job_says_why_on_the_terminal(folder: Path, profile: tuple[str, ...]) -> None:
    (folder / "params/wrong.yaml").write_text("scenes: {roots: {synscapes: nowhere}}\n")
    call = ["snakemake", "filter", "--cores", "1", *profile, "--configfile", "params/wrong.yaml"]
    result = subprocess.run(
        call, cwd=folder, env=environment(own_sources(folder)), capture_output=True, text=True, check=False
    )
    assert result.returncode == 1
    reason = (folder / "results/logs/scenes_synscapes.log").read_text().splitlines()[-1]
    assert reason.startswith("foggy scenes: ")
    assert f"results/logs/scenes_synscapes.log:\n    {reason}\n" in result.stderr
