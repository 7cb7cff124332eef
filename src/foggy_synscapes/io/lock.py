"""One engine at a time in a folder: locks of the operating system, which end with the processes that hold them.

Snakemake's own lock outlives a run that was killed and then has to be taken away by hand; these do not. Where an engine
is killed alone, its jobs work on: the next engine waits for them, or they would write over what it makes.
"""

import fcntl
import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import IO

from foggy_synscapes.errors import FoggyError

PATH = Path(".foggy/lock")
"""Held by an engine, or shared by jobs that `dvc repro` alone started, or a person."""
JOBS = Path(".foggy/jobs")
"""Shared by all jobs of any engine."""
OF_DVC = Path(".dvc/tmp/lock")
"""DVC's own lock, which it takes before it reads or removes anything: one of the operating system too."""
HELD = "FOGGY_LOCK"
"""Environment variable by which a job knows that its engine holds the lock."""


def hold(against_dvc: bool = False) -> ExitStack:
    """Take the lock of this folder for an engine, whose jobs know by HELD, until the result is closed.

    Jobs of an engine that was killed are waited for.

    against_dvc : also keep DVC itself out, which removes what a stage writes before our commands could refuse to run

    Raises FoggyError if another engine or a job of it is at work here.
    """
    with ExitStack() as held:
        held.enter_context(_take(PATH, fcntl.LOCK_EX))
        if against_dvc and OF_DVC.parents[1].is_dir():
            held.enter_context(_take(OF_DVC, fcntl.LOCK_EX))
        _wait_for_jobs()
        return held.pop_all()


def join() -> ExitStack:
    """Take part as a job, until the result is closed: keeps out engines, unless one started the job.

    Raises FoggyError if an engine is at work here that did not start the job.
    """
    with ExitStack() as held:
        if not os.environ.get(HELD):
            held.enter_context(_take(PATH, fcntl.LOCK_SH))
        _lock(held.enter_context(_opened(JOBS)), fcntl.LOCK_SH)
        return held.pop_all()


@contextmanager
def of_folder(path: Path) -> Iterator[None]:
    """Hold the lock of a folder of results, which is made, while the block runs; another holder's end is waited for."""
    try:
        path.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(path, os.O_RDONLY)
    except OSError as error:
        raise FoggyError(f"{path}: cannot be opened as a folder: {error.strerror}. Choose another --out.") from error
    try:
        _lock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


def is_free() -> bool:
    """Whether no engine and no job is at work in this folder."""
    if not PATH.is_file():
        return True
    try:
        _take(PATH, fcntl.LOCK_EX).close()
    except FoggyError:
        return False
    return True


def _wait_for_jobs() -> None:
    with _opened(JOBS) as jobs:
        try:
            _lock(jobs, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            print("waiting for the end of jobs whose engine was killed", file=sys.stderr, flush=True)
            _lock(jobs, fcntl.LOCK_EX)


def _take(path: Path, kind: int) -> IO[bytes]:
    file = _opened(path)
    try:
        _lock(file, kind | fcntl.LOCK_NB)
    except BlockingIOError as error:
        file.close()
        raise FoggyError(
            "another run is at work in this folder (Snakemake, DVC or a `foggy` command). Wait for its end or stop it: "
            "two at once would make the same files"
        ) from error
    return file


def _opened(path: Path) -> IO[bytes]:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        return open(path, "ab")
    except OSError as error:
        raise FoggyError(f"{path}: cannot be opened: {error.strerror}. Run this in a folder of your own.") from error


def _lock(file: IO[bytes] | int, kind: int) -> None:
    try:
        fcntl.flock(file, kind)
    except BlockingIOError:
        raise
    except OSError:
        # A file system without locks cannot tell; every file is written beside and renamed all the same.
        return
