"""Making results again beside those that are there, to see whether the same bytes come out."""

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.hashing import sha256
from foggy_synscapes.provenance.lineage import about
from foggy_synscapes.provenance.runs import instructions, read_runs, record_of, versions_now
from foggy_synscapes.results import RESULTS
from foggy_synscapes.steps import steps

SCRATCH = Path(".foggy")
OWN = {"results", ".foggy", ".snakemake", ".dvc", ".git"}
"""What a scratch copy of the project's folder has for itself; all else is linked."""


def options() -> dict[str, set[str]]:
    """Options of a job's command by its word, of all steps of the experiment: a record is data, and only these are run.

    >>> sorted(options()["fog"])
    ['--airlight', '--beta', '--completed', '--model', '--shard', '--stereo']
    """
    found: dict[str, set[str]] = {}
    for step in steps():
        if step.default:
            found.setdefault(step.word, set()).update(part for part in step.command.split() if part.startswith("--"))
    return found


@dataclass(frozen=True)
class Rebuilt:
    """A job that was done again: its command, outputs whose bytes differ now, and what else is not as it was."""

    command: str
    outputs: int
    different: list[str]
    circumstances: list[str]


def rebuild(word: str, path: Path, params: Path) -> Iterator[Rebuilt]:
    """Do the jobs of a step again whose outputs lie at or below `path`, in a scratch copy that is removed afterwards.

    Raises
    ------
    FoggyError
        If there is no such job, its record holds no command of this step, it fails, or a result is missing.
    """
    records = [
        record
        for record in read_runs().values()
        if record["command"][1:2] == [word] and any(Path(name).is_relative_to(path) for name in record["outputs"])
    ]
    if not records:
        raise FoggyError(f"{path}: no run record of foggy {word} speaks of it. Steps are {', '.join(options())}.")
    SCRATCH.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="rebuild-", dir=SCRATCH) as name:
        scratch = Path(name)
        _link(scratch, word)
        for record in records:
            yield _again(record, word, scratch, params.resolve())


def _link(scratch: Path, word: str) -> None:
    """A folder that looks like the project's, in which only the results of one step are its own."""
    for entry in Path().iterdir():
        if entry.name not in OWN:
            (scratch / entry.name).symlink_to(entry.resolve())
    (scratch / RESULTS / word).mkdir(parents=True)
    for entry in Path(RESULTS).iterdir():
        if entry.name != word:
            (scratch / RESULTS / entry.name).symlink_to(entry.resolve())


def _again(record: dict[str, Any], word: str, scratch: Path, params: Path) -> Rebuilt:
    command = record["command"]
    plain = all(isinstance(text, str) for text in command)
    if (
        not plain
        or command[:2] != ["foggy", word]
        or any(text.startswith("-") and text not in options()[word] for text in command[2:])
    ):
        raise FoggyError(f"run record of {next(iter(record['outputs']))}: {command} is no job of foggy {word}; not run")
    own = Path(RESULTS) / word
    leaving = [name for name in record["inputs"] if ".." in Path(name).parts]
    if leaving:
        raise FoggyError(f"run record of {next(iter(record['outputs']))}: its input {leaving[0]} leaves the folder")
    for name in [file for file in record["inputs"] if Path(file).is_relative_to(own)]:
        for file in (Path(name), record_of(Path(name))):
            (scratch / file).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, scratch / file)
    call = [sys.executable, "-m", "foggy_synscapes", *command[1:], "--params", str(params)]
    result = subprocess.run(call, cwd=scratch, capture_output=True, text=True, check=False)
    if result.returncode != 0:
        raise FoggyError(f"{' '.join(command)}: cannot be done again: {result.stderr.strip()}")
    outputs = list(record["outputs"])
    different = [name for name in outputs if not Path(name).is_file() or sha256(name) != sha256(scratch / name)]
    return Rebuilt(" ".join(command), len(outputs), different, list(_circumstances(record)))


def _circumstances(record: dict[str, Any]) -> Iterator[str]:
    """What decided bytes when the record was written and is otherwise now."""
    before, now = record.get("instructions", {}), instructions()
    for key in sorted({*before, *now}):
        if before.get(key) != now.get(key):
            yield f"instruction set: {key} was {_change(before.get(key), now.get(key))}"
    before = record.get("versions", {})
    for name, version in versions_now(before).items():
        if before[name] != version:
            yield f"{name} was {before[name]}, is {version}"
    changed = about(record)["code_changed"]
    if changed:
        yield f"code changed since: {', '.join(changed)}"
    if record.get("processes", 1) != 1:
        yield f"made by {record['processes']} processes, done again by 1"


def _change(before: str | None, now: str | None) -> str:
    """Two lists of words in brief: what one has and the other has not.

    >>> _change("AVX AVX2 AVX512F", "AVX AVX2")
    'with AVX512F, is without'
    >>> _change(None, "avx2")
    'not set, is avx2'
    """
    if before is None or now is None:
        return f"{before or 'not set'}, is {now or 'not set'}"
    old, new = set(before.split()), set(now.split())
    gone, come = " ".join(sorted(old - new)), " ".join(sorted(new - old))
    parts = [f"with {gone}, is without"] if gone else []
    return "; ".join(parts + ([f"without {come}, is with"] if come else []))
