"""Run records: beside its outputs, a step writes what made them, so that each number can be traced back.

A record holds the command, the params it read, SHA-256 of its inputs, sources and outputs, and versions.
It holds no time, host or absolute path, so that equal runs write equal records.
"""

import json
import platform
from collections.abc import Iterable
from importlib import metadata
from pathlib import Path
from typing import Any

from foggy_synscapes import __version__, closure
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.hashing import sha256

# Distributions whose name is not the name that is imported.
DISTRIBUTIONS = {"PIL": "pillow", "yaml": "pyyaml", "OpenImageIO": "OpenImageIO"}


def write_run(
    path: str | Path,
    *,
    command: list[str],
    params: dict[str, Any],
    inputs: Iterable[str | Path],
    outputs: Iterable[str | Path],
) -> None:
    """Write the record of one step; `command` starts with `foggy` and the step's word.

    `params` holds the values that the step read, without folders of the machine. `inputs` and `outputs` are
    files, named relative to the working directory.
    """
    word = command[1]
    record = {
        "command": command,
        "params": params,
        "inputs": _hashes(inputs),
        "outputs": _hashes(outputs),
        "code": {name: sha256(closure.FOLDER / name) for name in closure.sources(word)},
        "versions": versions(word),
    }
    write_text(path, json.dumps(record, indent=1, sort_keys=True, ensure_ascii=False) + "\n")


def versions(word: str) -> dict[str, str]:
    """Versions of Python, of this package and of the libraries that a command's sources import."""
    found = {"python": platform.python_version(), "foggy-synscapes": __version__}
    for name in closure.libraries(word):
        distribution = DISTRIBUTIONS.get(name, name)
        try:
            found[distribution] = metadata.version(distribution)
        except metadata.PackageNotFoundError:
            found[distribution] = "not installed"
    return found


def _hashes(paths: Iterable[str | Path]) -> dict[str, str]:
    return {Path(path).as_posix(): sha256(path) for path in sorted(paths, key=str)}


def read_runs(folder: str | Path = "results") -> dict[Path, dict[str, Any]]:
    """All run records below a folder by their own path, sorted.

    Raises
    ------
    FoggyError
        If a record is no JSON object with command, inputs and outputs.
    """
    records = {}
    for path in sorted(Path(folder).rglob("*run.json")):
        try:
            record = json.loads(path.read_text(encoding="utf-8"))
            complete = isinstance(record, dict) and {"command", "inputs", "outputs"} <= record.keys()
        except (OSError, ValueError) as error:
            raise FoggyError(f"{path}: not a readable run record: {error}. Run its step again.") from error
        if not complete:
            raise FoggyError(f"{path}: not a run record: command, inputs or outputs missing. Run its step again.")
        records[path] = record
    return records


def state(path: str | Path, recorded: str) -> str:
    """Whether a file is as recorded: "unchanged", "changed" or "missing"."""
    if not Path(path).is_file():
        return "missing"
    return "unchanged" if sha256(path) == recorded else "changed"
