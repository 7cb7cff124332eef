"""Run records: beside its outputs, a step writes what made them, so that each number can be traced back.

A record holds the command, the params it read, SHA-256 of its inputs and outputs, digests of its code, versions, and
the instruction set. It holds no time, host or absolute path, so that equal runs write equal records.
"""

import json
import platform
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from foggy_synscapes import __version__
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.files import check_name, read_json
from foggy_synscapes.io.hashing import sha256
from foggy_synscapes.jobs import Job
from foggy_synscapes.provenance import source_digest
from foggy_synscapes.provenance.instructions import gpu, instructions
from foggy_synscapes.provenance.recorded import recorded
from foggy_synscapes.results import RESULTS
from foggy_synscapes.steps import REGISTRIES


class Run:
    """One run of a job, from its start to its record: code, params and inputs are hashed when it starts.

    job : what is run; read : the files that it really reads, where some of the job's may be missing

    Attributes
    ----------
    inputs : SHA-256 by file; params : values of the job's keys; code, libraries : see `source_digest`

    Raises FoggyError as `checked_inputs` does.
    """

    def __init__(self, job: Job, read: Iterable[str | Path] | None = None) -> None:
        self.job = job
        self.code, self.libraries = code_of(job)
        self.params = recorded(job.params, *job.keys())
        self.inputs = checked_inputs(job.read() if read is None else read)

    def identity(self) -> dict[str, Any]:
        """All that decides the bytes of the outputs, but for the machine: to tell whether half a job may go on."""
        versions = {"python": platform.python_version(), **self.libraries}
        return {"code": self.code, "versions": versions, "params": self.params, "inputs": self.inputs}

    def finish(self, outputs: Iterable[str | Path] | None = None, processes: int = 1, device: str = "cpu") -> None:
        """Write the record beside the outputs: all of the job's, or those that are named.

        processes : number of processes that shared the arithmetic; device : where, "cpu" or "cuda"
        """
        written = self.job.outputs() if outputs is None else outputs
        made_by = self.identity()
        record = {
            **made_by,
            "versions": {**made_by["versions"], "foggy-synscapes": __version__},
            "command": self.job.command,
            "outputs": {Path(path).as_posix(): sha256(path) for path in sorted(written, key=str)},
            "instructions": instructions(),
            "processes": processes,
            **({"gpu": gpu()} if device == "cuda" else {}),
        }
        text = json.dumps(record, indent=1, sort_keys=True, ensure_ascii=False)
        write_text(self.job.output("record"), text + "\n")


def code_of(job: Job) -> tuple[dict[str, str], dict[str, str]]:
    """Digests by module of a job's code, and the versions of its libraries."""
    return source_digest.code(job.step.word, tuple(job.code()), REGISTRIES)


def versions_now(names: Iterable[str]) -> dict[str, str]:
    """Today's versions of what a record names: Python, this package and libraries."""
    own = {"python": platform.python_version(), "foggy-synscapes": __version__}
    return {name: own.get(name) or source_digest.version(name) for name in names}


def checked_inputs(paths: Iterable[str | Path]) -> dict[str, str]:
    """SHA-256 by file of what a step reads, made sure to be what the records of their makers say.

    To be called before anything is made of the files. Those outside of `results` have no maker and are only hashed.

    Raises
    ------
    FoggyError
        If a file is missing or has no record, or was changed, or only half of its step's files were written.
    """
    hashes: dict[str, str] = {}
    records: dict[Path, dict[str, Any]] = {}
    for path in map(Path, sorted({str(path) for path in paths})):
        if path.parts[0] == RESULTS and not path.is_file():
            raise FoggyError(f"{path}: missing. It is made by an earlier step: run `snakemake` or `dvc repro`.")
        hashes[path.as_posix()] = digest = sha256(path)
        if path.parts[0] != RESULTS:
            continue
        place = record_of(path)
        if not place.is_file():
            raise FoggyError(
                f"{path}: no run record beside it ({place}), so nothing says what made it. Was its step cut off, or "
                "the file put there by hand? Delete it and run the engine again."
            )
        if place not in records:
            records[place] = read_run(place)
        record = records[place]
        recorded = record["outputs"].get(path.as_posix())
        if recorded != digest:
            said = f"has sha256 {recorded[:12]}..." if recorded else "does not name it"
            raise FoggyError(
                f"{path}: is not what its step wrote: its sha256 is {digest[:12]}..., but {place} {said}. Make it "
                f"again: {' '.join(record['command'])} (with the --params of this run), or delete it and run the "
                "engine again."
            )
    return hashes


def record_of(path: Path) -> Path:
    """Where the run record of a result lies: `NAME.run.json` where the step writes several records, or `run.json`.

    >>> record_of(Path("nowhere/results/0000.csv")).as_posix()
    'nowhere/results/run.json'
    """
    own = path.with_suffix(".run.json")
    return own if own.is_file() else path.with_name("run.json")


def read_run(path: Path) -> dict[str, Any]:
    """One run record.

    Raises FoggyError if it is no JSON object with command, inputs and outputs, or names outputs outside of the folder.
    """
    record = read_json(path, "run record", "Run its step again.")
    if not isinstance(record, dict) or not {"command", "inputs", "outputs"} <= record.keys():
        raise FoggyError(f"{path}: not a run record: command, inputs or outputs missing. Run its step again.")
    try:
        for part in ("inputs", "outputs"):
            if not isinstance(record[part], dict) or not all(isinstance(each, str) for each in record[part].values()):
                raise ValueError(f"{part} are not SHA-256 by file")
        if not isinstance(record["command"], list) or not all(isinstance(word, str) for word in record["command"]):
            raise ValueError("the command is no list of words")
        for name in record["outputs"]:
            check_name(name)
    except ValueError as error:
        raise FoggyError(f"{path}: not a run record of this project: {error}. Delete it.") from error
    return record


def read_runs(folder: str | Path = RESULTS) -> dict[Path, dict[str, Any]]:
    """All run records below a folder by their own path, sorted; raises FoggyError as `read_run` does."""
    return {path: read_run(path) for path in sorted(Path(folder).rglob("*run.json"))}


def state(path: str | Path, recorded: str) -> str:
    """Whether a file is as recorded: "unchanged", "changed" or "missing"."""
    if not Path(path).is_file():
        return "missing"
    return "unchanged" if sha256(path) == recorded else "changed"
