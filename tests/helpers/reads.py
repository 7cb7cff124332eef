"""What a job really reads and writes, beside what it declares to the engines."""

import json
import os
import shlex
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Iterable
from contextlib import chdir
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from engines import environment

from foggy_synscapes.io.stamps import CACHE
from foggy_synscapes.io.tables import read_csv
from foggy_synscapes.jobs import Job
from foggy_synscapes.params import STAND_IN, load
from foggy_synscapes.provenance import source_digest
from foggy_synscapes.provenance.runs import code_of, record_of
from foggy_synscapes.steps import REGISTRIES, steps

HELPERS = Path(__file__).resolve().parent
LOCKS = ".foggy"
# The interpreter, installed packages and what the operating system says of itself.
SYSTEM = {sys.prefix, sys.base_prefix, *sysconfig.get_paths().values(), "/usr", "/lib", "/etc", "/proc", "/sys", "/dev"}


@dataclass
class Reads:
    """What a job did: files and folders read, files written, other things done, modules imported, processes seen."""

    files: set[Path] = field(default_factory=set)
    written: set[Path] = field(default_factory=set)
    folders: set[Path] = field(default_factory=set)
    other: set[str] = field(default_factory=set)
    modules: set[str] = field(default_factory=set)
    processes: int = 0


def watch(folder: Path, command: str) -> Reads:
    """Run a job's command in a clone and write down what it reads, worker processes included."""
    reads = Reads()
    with tempfile.TemporaryDirectory() as notes:
        paths = os.pathsep.join([str(HELPERS / "audit"), str(folder / "src")])
        changes = environment({"PYTHONPATH": paths, "FOGGY_AUDIT": notes})
        call = [sys.executable, "-m", "foggy_synscapes", *shlex.split(command)[1:]]
        result = subprocess.run(call, cwd=folder, env=changes, capture_output=True, text=True, check=False)
        assert result.returncode == 0, f"{command}: {result.stderr[-2000:]}"
        for note in sorted(Path(notes).glob("*.jsonl")):
            reads.processes += 1
            for line in note.read_text(encoding="utf-8").splitlines():
                kind, value = json.loads(line)
                if kind == "module":
                    reads.modules.add(Path(value).relative_to(folder / "src/foggy_synscapes").as_posix())
                elif kind in ("file", "folder", "written"):
                    {"file": reads.files, "folder": reads.folders, "written": reads.written}[kind].add(Path(value))
                else:
                    reads.other.add(f"{kind}: {value}")
    return reads


def undeclared(
    folder: Path, command: str, inputs: Iterable[str], outputs: Iterable[str], params: str, reads: Reads
) -> list[str]:
    """A line for each thing that a job reads or writes and does not declare."""
    inputs, outputs = list(inputs), list(outputs)
    word = shlex.split(command)[1]
    allowed = {folder / path for path in (*inputs, *outputs, params)} | _listed(folder, inputs, params)
    # What is declared is checked against the record that its maker wrote.
    with chdir(folder):
        allowed |= {folder / record_of(Path(path)) for path in inputs if path.startswith("results/")}
    code = counted(folder, command, params)
    # What a job writes beside its outputs, to go on after an interruption, is its own.
    # What is known of files is kept outside of the results.
    rooms = [folder / CACHE, *((folder / path).parent for path in outputs)]
    if word == "scenes":
        dataset = shlex.split(command)[shlex.split(command).index("--dataset") + 1]
        rooms.append(folder / "results/scenes" / dataset)
    problems = [f"reads {path}" for path in sorted(reads.files) if not _is_declared(path, allowed, code, rooms, folder)]
    problems += [
        f"writes {path}"
        for path in sorted(reads.written)
        if not _is_declared(path, {folder / path for path in outputs}, code, rooms, folder)
        and not path.is_relative_to(folder / LOCKS)
        and "__pycache__" not in path.parts
    ]
    problems += [
        f"lists {path}"
        for path in sorted(reads.folders)
        if path.is_relative_to(folder / "results") and not any(path.is_relative_to(room) for room in rooms)
    ]
    own = {folder / "src/foggy_synscapes" / name for name in reads.modules}
    imported = [path for path in sorted(own) if not _is_code(path, code, folder)]
    return problems + sorted(reads.other) + [f"imports {path}" for path in imported]


def counted(folder: Path, command: str, params: str) -> set[str]:
    """Names of the modules that count for a job, and of the files beside them."""
    with chdir(folder):
        values = load(params)
        jobs = [Job(step, values, chosen) for step in steps() for chosen in step.all_values(values)]
        wanted = shlex.split(command)[1:]
        (job,) = [job for job in jobs if job.command[1:] == wanted[: len(job.command) - 1] and _fits(job, wanted)]
        return set(code_of(job)[0])


def _fits(job: Job, wanted: list[str]) -> bool:
    """Whether a command is that of a job, with or without the option of its params file."""
    return wanted[len(job.command) - 1 :][:1] in ([], ["--params"])


@cache
def loaded_by_chassis(folder: Path) -> frozenset[str]:
    """Modules that every command loads to read params and the table of steps: what registries list, for their names.

    An import alone tells nothing of them; what a job takes of them counts for it by the table.
    """
    code = "import sys; from foggy_synscapes import cli, params, steps; params.load(sys.argv[1]); steps.steps();"
    code += "from foggy_synscapes.provenance import runs; print(*(name for name in sys.modules))"
    call = [sys.executable, "-c", code, "params.yaml"]
    told = subprocess.run(
        call,
        cwd=folder,
        env=environment({"PYTHONPATH": str(folder / "src")}),
        capture_output=True,
        text=True,
        check=True,
    )
    package = "foggy_synscapes"
    return frozenset(
        name.removeprefix(package).lstrip(".") for name in told.stdout.split() if name.partition(".")[0] == package
    )


def _is_code(path: Path, code: set[str], folder: Path) -> bool:
    """Whether a source file counts for a job, is loaded by every command, or is checked by a hash."""
    inside = path.relative_to(folder / "src/foggy_synscapes")
    name = ".".join(inside.with_suffix("").parts).removesuffix("__init__").rstrip(".")
    free = (*source_digest.CHASSIS, *source_digest.CHECKED)
    return (
        name in code
        or inside.as_posix() in code
        or name in ("", "__main__", *loaded_by_chassis(folder))
        # Registries look through their packages for what declares an entry.
        or inside.parent.as_posix() in {registry.package.replace(".", "/") for registry in REGISTRIES.values()}
        or any(name == part or name.startswith(f"{part}.") for part in free)
    )


def _is_declared(path: Path, allowed: set[Path], code: set[str], rooms: list[Path], folder: Path) -> bool:
    if path in allowed or any(path.is_relative_to(place) for place in SYSTEM):
        return True
    if path.is_relative_to(folder / "src"):
        if path.parent.name == "__pycache__":  # compiled by Python, or by Numba as KERNEL.function-LINE.py311.nbi
            path = path.parent.parent / f"{path.name.split('.')[0]}.py"
        return "egg-info" in str(path) or path.is_dir() or _is_code(path, code, folder)
    if path.is_relative_to(folder):
        if path.is_dir():
            # Opened to be synced after a file in it was written; what is listed is another event.
            return any(path.is_relative_to(room) for room in rooms)
        hidden = any(part.startswith(".") for part in path.relative_to(folder).parts) or "snapshot" in path.name
        return any(path.is_relative_to(room) for room in rooms) and (hidden or "scenes" in path.parts)
    # Matplotlib keeps a list of the fonts that it found; the font of the figures is the one that comes with it.
    if path.name.startswith("fontlist-"):
        return True
    return path.is_relative_to(tempfile.gettempdir()) or path.is_relative_to(HELPERS / "audit")


def _listed(folder: Path, inputs: Iterable[str], params: str) -> set[Path]:
    """Files that declared indexes and lists name, with the hash of their content."""
    roots = load(folder / params).scenes.roots
    homes = {name: folder / ("results/scenes/" + name if root == STAND_IN else root) for name, root in roots.items()}
    found = set()
    for path in inputs:
        parts = Path(path).parts
        if parts[:3] == ("results", "scenes", "index") and path.endswith(".csv"):
            found |= {homes[parts[3]] / line["path"] for line in read_csv(folder / path)}
        elif parts[:2] == ("results", "subset"):
            for line in read_csv(folder / path):
                for uri in (line["image"], line["label"]):
                    scheme, _, place = uri.partition(":")
                    base = folder / "results/fog" if scheme == "fog" else homes[scheme]
                    found.add(base / place.partition("#")[0])
    return found
