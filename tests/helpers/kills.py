"""Runs of an engine that are killed at random moments."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

from engines import SMOKE, clone, environment, for_dvc

ENGINES = ("snakemake", "dvc")
# All processes at once as in a power cut; the engine alone, its jobs run on; one job or one of its workers alone.
HOW = ("all", "engine", "worker")


def call(engine: str) -> list[str]:
    """The normal command of an engine, which has to work after every kill, too."""
    if engine == "dvc":
        return [sys.executable, "workflow/repro.py"]
    return [sys.executable, "-m", "snakemake", "--cores", "2", *SMOKE]


def prepared(engine: str, folder: Path) -> Path:
    """A clone in which an engine can start."""
    return clone(folder) if engine == "snakemake" else for_dvc(clone(folder))


def descendants(process: int) -> list[int]:
    """Processes that a process started, and those that they started."""
    found: list[int] = []
    try:
        tasks = list(Path(f"/proc/{process}/task").iterdir())
    except OSError:
        return found
    for task in tasks:
        try:
            children = [int(word) for word in (task / "children").read_text().split()]
        except OSError:
            continue
        for child in children:
            found += [child, *descendants(child)]
    return found


def kill(engine: subprocess.Popen, how: str, choice: random.Random) -> None:
    """Kill -9 what `how` says; the others, where the engine dies alone, are left to themselves."""
    jobs = descendants(engine.pid)
    if how == "worker" and jobs:
        victims = [choice.choice(jobs)]
    else:
        victims = [engine.pid] if how == "engine" else [engine.pid, *jobs]
    for victim in victims:
        try:
            os.kill(victim, signal.SIGKILL)
        except ProcessLookupError:
            continue  # it has just ended by itself


def run_until(engine: str, folder: Path, log: Path, seconds: float | None, how: str, choice: random.Random) -> str:
    """Run the normal command, and kill it after so many seconds: `done`, `killed` or `failed`, where nobody killed it.

    With None it is not killed.
    """
    with log.open("ab") as told:
        process = subprocess.Popen(
            call(engine), cwd=folder, env=environment(), stdout=told, stderr=told, start_new_session=True
        )
        try:
            process.wait(seconds)
        except subprocess.TimeoutExpired:
            kill(process, how, choice)
            # Where one worker died, its engine ends by itself, with an error.
            process.wait()
            return "killed"
    return "done" if process.returncode == 0 else "failed"


def pause() -> None:
    """Give what was killed the moment that the operating system takes to clear it away."""
    time.sleep(0.2)
