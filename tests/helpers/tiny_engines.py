"""How both engines decide on the tiny chain, in this process: what Snakemake plans of what it is told, and DVC's rule.

Real runs of both (`tests/workflow/test_stateful.py`) hold these against the engines themselves.
"""

import json
import shutil
from contextlib import chdir
from dataclasses import dataclass, field
from pathlib import Path

import pytest
import tiny_chain

from foggy_synscapes.io.hashing import sha256
from foggy_synscapes.jobs import Job
from foggy_synscapes.params import Params
from foggy_synscapes.provenance.current import Again, changed_raw_data, out_of_date
from foggy_synscapes.provenance.runs import OF_DVC, PLANNED, params_digest, recorded
from foggy_synscapes.stages.code import code as write_code
from foggy_synscapes.steps import all_jobs, code_file


@dataclass
class Ran:
    """Jobs that a command ran, in their order, and those of them that ran because one before them did."""

    jobs: list[str] = field(default_factory=list)
    followed: set[str] = field(default_factory=set)


def name(job: Job) -> str:
    return " ".join(job.command[2:])


def reads(job: Job) -> list[str]:
    """Files that have to be there before a job runs."""
    return [path.as_posix() for path in job.awaited()]


def writes(job: Job) -> list[str]:
    return [path.as_posix() for path in (*job.outputs(), job.output("record"))]


def planned(jobs: list[Job], again: list[Again]) -> set[str]:
    """What Snakemake plans: forced jobs, missing targets, what these miss, and what takes files that are not there."""
    forced = {name(each.node.job) for each in again if each.node.is_there}
    run = {name(each.node.job) for each in again}
    alone = {path for each in again if each.alone for path in each.node.written}
    makers = {path: job for job in jobs for path in writes(job)}
    needs = {
        name(job): {path for path in reads(job) if path in makers and (name(job) in run or path not in alone)}
        for job in jobs
    }
    asked, waiting = {name(job) for job in jobs if job.step.word == "tables"}, []
    by_name = {name(job): job for job in jobs}
    reached = asked | {name(makers[path]) for path in alone}
    upwards = list(reached)
    while upwards:
        for path in needs[upwards.pop()]:
            maker = name(makers[path])
            if maker not in reached:
                reached.add(maker)
                upwards.append(maker)
    for each in reached:
        missing = each in asked and not all(Path(path).exists() for path in writes(by_name[each]))
        if each in forced or missing:
            waiting.append(each)
    found = set(waiting)
    while waiting:
        each = waiting.pop()
        absent = {name(makers[path]) for path in needs[each] if not Path(path).exists()}
        made = {path for path in writes(by_name[each]) if not Path(path).exists()}
        more = (absent | {other for other in reached if needs[other] & made}) - found
        found |= more
        waiting += more
    return found


def snakemake(stop_at: int = -1, stop: tiny_chain.Stop | None = None) -> Ran:
    """The normal command: list raw data anew where it says so, plan, run; killed in the job of a number."""
    params, ran = tiny_chain.params_here(), Ran()
    jobs = all_jobs(params)
    with pytest.MonkeyPatch.context() as environment:
        environment.setenv(PLANNED, params_digest(params))
        _plan_and_run(params, jobs, ran, stop_at, stop)
    return ran


def _plan_and_run(params: Params, jobs: list[Job], ran: Ran, stop_at: int, stop: tiny_chain.Stop | None) -> None:
    if changed_raw_data(jobs[0]):
        _run(jobs[0], ran, stop_at, stop)
    asked = [path for job in jobs if job.step.word == "tables" for path in writes(job)]
    plan = planned(jobs, out_of_date(params, asked=asked))
    for job in jobs:
        if name(job) in plan:
            _run(job, ran, stop_at, stop)


def _run(job: Job, ran: Ran, stop_at: int, stop: tiny_chain.Stop | None) -> None:
    if any(_follows(job, other) for other in ran.jobs):
        ran.followed.add(name(job))
    ran.jobs.append(name(job))
    tiny_chain.run(job, stop if len(ran.jobs) - 1 == stop_at else None)


def _follows(job: Job, other: str) -> bool:
    """Whether a job comes after another in the chain."""
    return tiny_chain.WORDS.index(other.split()[0]) < tiny_chain.WORDS.index(job.step.word)


@dataclass
class Dvc:
    """What DVC keeps: of each stage what it read and wrote when it last ran, and the contents that runs gave."""

    lock: dict[str, tuple[str, str]] = field(default_factory=dict)
    cache: dict[str, dict[str, bytes]] = field(default_factory=dict)

    def repro(self, stop_at: int = -1, stop: tiny_chain.Stop | None = None) -> Ran:
        """The normal command, `make repro`."""
        params, ran = tiny_chain.params_here(), Ran()
        jobs = all_jobs(params)
        write_code(params)
        with pytest.MonkeyPatch.context() as environment:
            environment.setenv(OF_DVC, "stage")
            environment.setenv(PLANNED, params_digest(params))
            self._stages(jobs, ran, stop_at, stop)
        return ran

    def _stages(self, jobs: list[Job], ran: Ran, stop_at: int, stop: tiny_chain.Stop | None) -> None:
        for job in jobs:
            key, outs = _key(job), _outs(job)
            known = self.lock.get(name(job))
            # What raw files hold is no part of what DVC compares, so an index is listed, never taken from its cache.
            lists = job.step.word == "scenes"
            if known == (key, outs) and not (lists and changed_raw_data(job)):
                continue
            if key in self.cache and not lists:
                for path, data in self.cache[key].items():
                    Path(path).parent.mkdir(parents=True, exist_ok=True)
                    Path(path).write_bytes(data)
            else:
                for path in writes(job):
                    Path(path).unlink(missing_ok=True)
                _run(job, ran, stop_at, stop)
            self.commit(job)

    def commit(self, job: Job) -> None:
        """Take what is there for what the stage makes."""
        key = _key(job)
        self.lock[name(job)] = key, _outs(job)
        self.cache[key] = {path: Path(path).read_bytes() for path in writes(job) if Path(path).is_file()}

    def adopt(self) -> bool:
        """`foggy adopt --from snakemake`: take over what is up to date; whether it was."""
        params = tiny_chain.params_here()
        jobs = all_jobs(params)
        there = all(Path(path).exists() for job in jobs for path in writes(job))
        if changed_raw_data(jobs[0]) or out_of_date(params) or not there:
            return False
        write_code(params)
        for job in jobs:
            self.commit(job)
        return True


def _key(job: Job) -> str:
    """What DVC compares of a stage: files that it depends on, the digest of its code, and params, as they are now."""
    # Weights are an input of Snakemake's; DVC knows their name alone.
    known = [path for path in map(str, job.read()) if path != tiny_chain.WEIGHTS]
    deps = {path: sha256(path) if Path(path).is_file() else None for path in known}
    params = recorded(tiny_chain.params_here(), *job.keys())
    return json.dumps([name(job), deps, params, Path(code_file(job.step, job.values)).read_text()], sort_keys=True)


def _outs(job: Job) -> str:
    return json.dumps({path: sha256(path) if Path(path).is_file() else None for path in writes(job)})


def contents(jobs: list[Job]) -> dict[str, str | None]:
    """SHA-256 of every file that jobs write; None where it is missing."""
    return {path: sha256(path) if Path(path).is_file() else None for job in jobs for path in writes(job)}


def clean(folder: Path) -> dict[str, str | None]:
    """What a clean run of the state in the working folder makes, made in `folder`."""
    for entry in ("toy", "raw"):
        shutil.copytree(entry, folder / entry)
    for entry in ("params.yaml", tiny_chain.WEIGHTS):
        if Path(entry).is_file():
            shutil.copy(entry, folder / entry)
    with chdir(folder):
        jobs = all_jobs(tiny_chain.params_here())
        for job in jobs:
            tiny_chain.run(job)
        return contents(jobs)
