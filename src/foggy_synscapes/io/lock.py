"""One engine at a time in a folder: a lock of the operating system, which ends with the process that holds it.

Snakemake's own lock outlives a run that was killed and then has to be taken away by hand; this one does not.
"""

import fcntl
import os
from pathlib import Path
from typing import IO

from foggy_synscapes.errors import FoggyError

PATH = Path(".foggy/lock")
HELD = "FOGGY_LOCK"
"""Environment variable by which a job knows that its engine holds the lock."""


def hold() -> IO[bytes]:
    """Take the lock of this folder for an engine that starts several jobs; it is held while the file stays open.

    Raises FoggyError if another engine or a job of it is at work here.
    """
    PATH.parent.mkdir(parents=True, exist_ok=True)
    return _take(fcntl.LOCK_EX)


def join() -> IO[bytes] | None:
    """Keep Snakemake from starting beside a job that it did not start; None where it never ran here, or did start it.

    Raises FoggyError if Snakemake is at work here.
    """
    if os.environ.get(HELD) or not PATH.is_file():
        return None
    return _take(fcntl.LOCK_SH)


def is_free() -> bool:
    """Whether no engine and no job is at work in this folder."""
    if not PATH.is_file():
        return True
    try:
        _take(fcntl.LOCK_EX).close()
    except FoggyError:
        return False
    return True


def _take(kind: int) -> IO[bytes]:
    file = open(PATH, "ab")  # noqa: SIM115 (open for as long as the lock is to be held)
    try:
        fcntl.flock(file, kind | fcntl.LOCK_NB)
    except BlockingIOError as error:
        file.close()
        raise FoggyError(
            "another run is at work in this folder (Snakemake, DVC or a `foggy` command). Wait for its end or stop it: "
            "two at once would make the same files"
        ) from error
    except OSError:
        # A file system without locks cannot tell; every file is written beside and renamed all the same.
        return file
    return file
