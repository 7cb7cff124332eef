"""What the benchmarks of whole runs share: clones of this project to run in, calls in them, and hashes of results."""

import hashlib
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

ROOT = Path(__file__).resolve().parent.parent


@dataclass(frozen=True)
class Call:
    """A finished program: status, what it printed, seconds on the clock, peak memory in MB of its largest process."""

    status: int
    text: str
    seconds: float
    megabytes: float


def clone(folder: Path) -> Path:
    """Copy the project's files as they stand, edited ones too, without anything that is generated or ignored."""
    names = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    for name in filter(None, names.stdout.split("\0")):
        source, target = ROOT / name, folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if source.exists() or source.is_symlink():
            shutil.copy2(source, target, follow_symlinks=False)
    return folder


def environment(folder: Path, **variables: str) -> dict[str, str]:
    """The environment of a call in a clone: its own sources come first, and the programs of this Python."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    return {**os.environ, "PATH": path, "PYTHONPATH": str(folder / "src"), **variables}


def call(folder: Path, *command: str, good: bool = True, **variables: str) -> Call:
    """Run a command in a clone and measure it.

    good : whether it has to end with status 0; SystemExit with the end of what it printed where it does not
    """
    started = perf_counter()
    with subprocess.Popen(
        command,
        cwd=folder,
        env=environment(folder, **variables),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    ) as process:
        text = process.stdout.read()
        # Waited for by hand: only so the kernel tells the peak memory of this process and its children.
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    done = Call(process.returncode, text, perf_counter() - started, usage.ru_maxrss / 1024)
    if good and done.status:
        raise SystemExit(f"{' '.join(command)}\nended with status {done.status} in {folder}:\n{text[-6000:]}")
    return done


def hashes(folder: Path) -> dict[str, str]:
    """SHA-256 by path of every result that is not a log, a benchmark or a cache."""
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted((folder / "results").rglob("*"))
        if path.is_file()
        and path.relative_to(folder / "results").parts[0] not in ("logs", "benchmarks", "paper")
        and path.name not in (".gitignore", ".snakemake_timestamp")
    }


def table(header: tuple[str, ...], rows: list[tuple]) -> str:
    """A Markdown table."""
    lines = [header, tuple("---" for _ in header), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)
