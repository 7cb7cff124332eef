"""Writing files so that a reader sees the old content or the new, never a part of it."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from foggy_synscapes.errors import FoggyError


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
        descriptor, temporary = tempfile.mkstemp(prefix=f".{path.name}.", suffix=".part", dir=path.parent)
        with os.fdopen(descriptor, "wb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, path)
        temporary = None
        _sync_folder(path.parent)
    except OSError as error:
        raise FoggyError(
            f"{path}: cannot be written: {error.strerror or error}. Check space and permissions."
        ) from error
    finally:
        if temporary is not None:
            Path(temporary).unlink(missing_ok=True)


def remove_leftovers(folder: str | Path) -> None:
    """Remove what killed processes left half-written below a folder; to be called while none writes there."""
    for path in Path(folder).rglob(".*.part"):
        path.unlink(missing_ok=True)


def write_bytes(path: str | Path, data: bytes) -> None:
    """Replace the content of `path` by `data`, or leave it as it was (see `replacing`)."""
    with replacing(path) as file:
        file.write(data)


def write_text(path: str | Path, text: str) -> None:
    """Replace the content of `path` by `text` in UTF-8 with the line ends that it has."""
    write_bytes(path, text.encode("utf-8"))


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _sync_folder(folder: Path) -> None:
    # Without this the rename itself may be lost in a power cut.
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
