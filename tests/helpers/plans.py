"""What both engines find out of date after a change, against what is listed."""

import tempfile
from contextlib import chdir
from pathlib import Path

from changes import Change, changed, matching
from dvc.repo import Repo
from engines import job, own_sources, planned, run


def write_code(folder: Path) -> None:
    """Run the stage that only writes what code means: what follows from an edit is known to DVC after it."""
    run(folder, "foggy_synscapes", "code", changes=own_sources(folder))


def out_of_date(folder: Path) -> set[str]:
    """Jobs that DVC finds out of date before it runs any, but for the one that only writes what code means."""
    write_code(folder)
    with chdir(folder), Repo() as repo:
        commands = {stage.addressing: job(stage.cmd) for stage in repo.index.stages}
        return {commands[name] for name in repo.status()} - {"code"}


def followers(jobs: dict, start: set[str]) -> set[str]:
    """Jobs and all that follow them by the graph; a training only waits for shards."""
    found, waiting = set(start), set(start)
    while waiting:
        made = {path for name in waiting for path in jobs[name][1] if not path.endswith(".tar")}
        waiting = {name for name, (inputs, _, _) in jobs.items() if inputs & made} - found
        found |= waiting
    return found


def compare_plans(change: Change, snakemake: Path, dvc: Path) -> tuple[set[str], list[str]]:
    """Jobs out of date at once, and a line for each difference between what engines plan and what is listed."""
    with tempfile.TemporaryDirectory() as spare, changed(snakemake, change, Path(spare)):
        jobs = planned(snakemake, "--forceall", *change.options)
        plan = set(planned(snakemake, *change.options))
    with tempfile.TemporaryDirectory() as spare, changed(dvc, change, Path(spare)):
        found = out_of_date(dvc)
    write_code(dvc)
    direct = matching(jobs, change.direct)
    first = direct if change.snakemake is None else matching(jobs, change.snakemake)
    problems = differences("Snakemake plans", plan, followers(jobs, first))
    listed = direct if change.dvc is None else matching(jobs, change.dvc)
    return direct, problems + differences("DVC plans", found, listed)


def differences(who: str, found: set[str], listed: set[str]) -> list[str]:
    """A line for each job of one set that is not in the other."""
    lines = [f"{who} without need: {name}" for name in sorted(found - listed)]
    return lines + [f"{who} not, and leaves stale: {name}" for name in sorted(listed - found)]
