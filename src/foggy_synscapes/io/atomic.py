"""Writing files so that a reader sees the old content or the new, never a part of it."""

import os
import secrets
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from foggy_synscapes.errors import FoggyError

_written: dict[str, list[int]] = {}
"""Size, times of modification and of change in ns, and inode of the files that this process wrote, as it left them."""


@contextmanager
def replacing(path: str | Path) -> Iterator[IO[bytes]]:
    """Give a binary file that takes the place of `path` when the block ends without an error.

    The bytes go to a hidden file beside `path`, are synced to disk and then renamed; on an error the
    hidden file is removed and `path` stays as it was. Parent folders are made.

    Raises
    ------
    FoggyError
        If the operating system refuses: no space, no permission, a file where a folder must be.
    """
    path = Path(path)
    temporary = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        beside = path.parent / f".{path.name}.{secrets.token_hex(4)}.part"
        # With the permissions of any new file: asking for the process's mask would change it for all threads meanwhile.
        descriptor = os.open(beside, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666)
        temporary = beside
        with os.fdopen(descriptor, "wb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
            # Renaming sets the time of change anew, to be asked for afterwards.
            os.replace(temporary, path)
            status = os.fstat(file.fileno())
        _written[os.path.abspath(path)] = [status.st_size, status.st_mtime_ns, status.st_ctime_ns, status.st_ino]
        temporary = None
        _sync_folder(path.parent)
    except OSError as error:
        raise FoggyError(
            f"{path}: cannot be written: {error.strerror or error}. Check space and permissions."
        ) from error
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)


def altered(path: str | Path) -> bool:
    """Whether somebody changed or removed a file since this process wrote it; False of files that it did not write."""
    left = _written.get(os.path.abspath(path))
    if left is None:
        return False
    try:
        now = os.stat(path)
    except OSError:
        return True
    return [now.st_size, now.st_mtime_ns, now.st_ctime_ns, now.st_ino] != left


def remove_leftovers(folder: str | Path, of: Collection[str] | None = None) -> None:
    """Remove what killed processes left half-written below a folder; to be called while none writes there.

    of : names of the files that none writes, where others may be written meanwhile
    """
    for path in Path(folder).rglob(".*.part"):
        if (of is None or path.name[1:].rsplit(".", 2)[0] in of) and not path.is_dir():
            path.unlink(missing_ok=True)


def write_bytes(path: str | Path, data: bytes) -> None:
    """Replace the content of `path` by `data`, or leave it as it was (see `replacing`)."""
    with replacing(path) as file:
        file.write(data)


def write_text(path: str | Path, text: str) -> None:
    """Replace the content of `path` by `text` in UTF-8 with the line ends that it has."""
    write_bytes(path, text.encode("utf-8"))


def _sync_folder(folder: Path) -> None:
    # Without this the rename itself may be lost in a power cut.
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
