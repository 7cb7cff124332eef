"""Jobs that begin in milliseconds: forks of one process that has loaded the large libraries, in place of new ones.

A whole run of the smallest params is some sixty jobs, of which each loads PyTorch for two seconds and works for less.
Only libraries of others are loaded ahead, so a job imports this project's modules as it would in a process of its own.
"""

import json
import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path

LIBRARIES = (
    "matplotlib.pyplot",
    "numba",
    "OpenImageIO",
    "pandas",
    "pydantic",
    "torch",
    "torch.optim",
    "torch.utils.data",
)
BYTES = 1 << 17  # of a call: its arguments, folder and environment

# Run without the site module: the interpreter is there in 15 ms.
PROGRAM = """\
#!{python} -IS
import json, os, signal, socket, sys
server = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
server.connect({address!r})
call = json.dumps([sys.argv[1:], os.getcwd(), dict(os.environ)]).encode()
socket.send_fds(server, [call], [0, 1, 2])
job = int(server.recv(32))
for number in (signal.SIGINT, signal.SIGTERM):
    signal.signal(number, lambda number, _: os.kill(job, number))
sys.exit(int(server.recv(32) or b"1"))
"""


@contextmanager
def jobs(folder: Path, changes: Mapping[str, str]) -> Iterator[dict[str, str]]:
    """Put a program `foggy` in front of the path, in a new folder; gives the environment's changes for a run.

    changes : variables of that run; those that Python reads at its start, such as PYTHONHASHSEED, hold for its jobs
    """
    folder.mkdir(parents=True)
    address = str(folder / "socket")
    program = folder / "foggy"
    program.write_text(PROGRAM.format(python=sys.executable, address=address))
    program.chmod(0o755)
    path = os.pathsep.join((str(folder), str(Path(sys.executable).parent), os.environ["PATH"]))
    ready, told = os.pipe()
    call = [sys.executable, __file__, address, str(told)]
    with subprocess.Popen(call, env={**os.environ, **changes}, pass_fds=[told]) as server:
        os.close(told)
        assert os.read(ready, 1), "the server of jobs did not begin"
        os.close(ready)
        try:
            yield {**changes, "PATH": path}
        finally:
            server.terminate()


def serve(address: str, told: int) -> None:
    """Fork a process for every call, until SIGTERM."""
    signal.signal(signal.SIGTERM, lambda *_: os._exit(0))
    for name in LIBRARIES:
        import_module(name)
    server = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    server.bind(address)
    server.listen()
    os.write(told, b"1")
    os.close(told)
    while True:
        caller, _ = server.accept()
        call, files, _, _ = socket.recv_fds(caller, BYTES, 3)
        job = os.fork()
        if job == 0:
            server.close()
            caller.close()
            work(*json.loads(call), files)
        for file in files:
            os.close(file)
        caller.send(str(job).encode())
        threading.Thread(target=wait, args=(job, caller), daemon=True).start()


def wait(job: int, caller: socket.socket) -> None:
    """Tell the caller how its job ended."""
    status = os.waitstatus_to_exitcode(os.waitpid(job, 0)[1])
    with caller:
        caller.send(str(status if status >= 0 else 128 - status).encode())


def work(arguments: list[str], folder: str, environment: dict[str, str], files: list[int]) -> None:
    """One job, in its own process: the command line of the project."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    for number, file in enumerate(files):
        os.dup2(file, number)
        os.close(file)
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    sys.path[:0] = filter(None, environment.get("PYTHONPATH", "").split(os.pathsep))
    sys.argv = ["foggy", *arguments]
    status = 1
    try:
        from foggy_synscapes.cli import main

        status = main()
    except SystemExit as error:
        status = error.code if isinstance(error.code, int) else int(error.code is not None)
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status or 0)


if __name__ == "__main__":
    serve(sys.argv[1], int(sys.argv[2]))
