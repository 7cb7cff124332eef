"""What benchmarks and long tests of whole runs share: clones of this project to run in, and measured calls in them."""

import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

from engines import ROOT, hashes

__all__ = ["ROOT", "Call", "call", "clone", "free_ports", "hashes", "stop_in_order", "table", "wait_until"]
PATIENCE = 60  # seconds that a server may take to start or to notice something


def stop_in_order() -> None:
    """Let a kill (SIGTERM) end this program as an error does: what it started is stopped, what it wrote removed."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))


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
        try:
            text = process.stdout.read()
        except BaseException:
            process.terminate()
            raise
        # Waited for by hand: only so the kernel tells the peak memory of this process and its children.
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    done = Call(process.returncode, text, perf_counter() - started, usage.ru_maxrss / 1024)
    if good and done.status:
        raise SystemExit(f"{' '.join(command)}\nended with status {done.status} in {folder}:\n{text[-6000:]}")
    return done


def table(header: tuple[str, ...], rows: list[tuple]) -> str:
    """A Markdown table."""
    lines = [header, tuple("---" for _ in header), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)


def free_ports(count: int) -> list[int]:
    """Ports of the loopback interface that nobody listens on."""
    with ExitStack() as stack:
        sockets = [stack.enter_context(socket.socket()) for _ in range(count)]
        for each in sockets:
            each.bind(("127.0.0.1", 0))
        return [each.getsockname()[1] for each in sockets]


def wait_until(ready: Callable[[], bool], what: str, seconds: float = PATIENCE) -> None:
    """Ask twice a second; SystemExit where it takes too long."""
    end = time.monotonic() + seconds
    while not ready():
        if time.monotonic() > end:
            raise SystemExit(f"{what}: not within {seconds:.0f} s")
        time.sleep(0.5)
