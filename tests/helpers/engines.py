"""Clones of the project, and runs and plans of both engines in them."""

import hashlib
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.params import load, resolved

ROOT = Path(__file__).resolve().parents[2]
PROJECT = (
    "Snakefile",
    "workflow",
    "profiles",
    "src",
    "params",
    "params.yaml",
    "examples",
    "dvc.yaml",
    ".dvc/config",
    ".dvcignore",
    ".gitignore",
    "requirements.lock",
)
SMOKE = ("--configfile", "params/smoke.yaml")
VERBOSE = ("--printshellcmds", "--quiet", "host")  # the profile of this project is quieter than what is read here
PLAN = ("--dry-run", "--cores", "1", *VERBOSE)


def clone(folder: Path) -> Path:
    """A copy of the project's files, as it stands, without results."""
    for name in PROJECT:
        source, target = ROOT / name, folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if source.is_dir():
            shutil.copytree(source, target, ignore=shutil.ignore_patterns("__pycache__", "*.egg-info"))
        else:
            shutil.copy(source, target)
    return folder


def complete(path: Path) -> str:
    """A params file as DVC reads it, with what it leaves to the packaged defaults."""
    return resolved.text(load(path))


def for_dvc(folder: Path, params: str = "params/smoke.yaml") -> Path:
    """Make a clone one that DVC runs with these params."""
    write_text(folder / "params.yaml", complete(folder / params))
    subprocess.run(["git", "init", "--quiet"], cwd=folder, check=True)
    return folder


def environment(changes: Mapping[str, str] | None = None) -> dict[str, str]:
    """The environment of a run in a clone: that of this Python."""
    values = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    return {**values, **(changes or {})}


def own_sources(folder: Path) -> dict[str, str]:
    """What makes a run in a clone use the clone's sources instead of this project's."""
    return {"PYTHONPATH": str(folder / "src")}


def run(folder: Path, module: str, *arguments: str, changes: Mapping[str, str] | None = None) -> str:
    """Run an engine of this environment in a folder; its output, also where it fails, which is an error."""
    call = [sys.executable, "-m", module, *arguments]
    result = subprocess.run(call, cwd=folder, env=environment(changes), capture_output=True, text=True, check=False)
    logs = [] if result.returncode == 0 else sorted((folder / "results/logs").rglob("*.log"))
    told = "".join(
        f"\n--- {log}\n{log.read_text()}" for log in logs if "Error" in log.read_text() or "foggy " in log.read_text()
    )
    assert result.returncode == 0, result.stdout[-3000:] + result.stderr[-5000:] + told[-5000:]
    return result.stdout + result.stderr


def hashes(folder: Path) -> dict[str, str]:
    """SHA-256 of every result that is not a log, a benchmark, a cache, or what DVC alone is told of code."""
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted((folder / "results").rglob("*"))
        if path.is_file()
        and path.relative_to(folder / "results").parts[0] not in ("logs", "benchmarks", "code")
        and path.name not in (".gitignore", ".snakemake_timestamp")
    }


def job(command: str) -> str:
    """Short name of a job: the words of its command without options' names, e.g. `fog 0.005 0000`.

    >>> job("foggy train --network bisenet --row C --seed 0 --params params/smoke.yaml")
    'train bisenet C 0'
    """
    words = shlex.split(re.sub(r" --params \S+", "", command))[1:]
    return " ".join(word.removeprefix("--") for word in words if word == "--airlight" or not word.startswith("--"))


def planned(folder: Path, *options: str) -> dict[str, tuple[frozenset[str], frozenset[str], str]]:
    """Jobs that Snakemake would run, each with its inputs, its outputs and its command."""
    told = run(folder, "snakemake", *PLAN, *options, *SMOKE, changes=own_sources(folder))
    return {job(command): (*paths, command) for command, paths in in_plan(told).items()}


def in_plan(told: str) -> dict[str, tuple[frozenset[str], frozenset[str]]]:
    """Inputs and outputs of the jobs of a dry run, by their command."""
    jobs = {}
    for block in re.split(r"\n(?=(?:local)?rule )", told):
        command = re.search(r"^Shell command: (foggy .*?)(?= > )", block, re.MULTILINE)
        if command:
            found = [re.search(rf"^ +{name}: (.*)$", block, re.MULTILINE) for name in ("input", "output")]
            jobs[command[1]] = tuple(frozenset(paths[1].split(", ") if paths else ()) for paths in found)
    return jobs


def ran(told: str) -> set[str]:
    """Jobs that an engine started, from what it printed."""
    return {
        job(command) for command in re.findall(r"^\s*(?:Shell command: |> )(foggy .*?)(?= > |$)", told, re.MULTILINE)
    }
