"""The one way in: plain files are opened and nothing else, nothing is read without bound, and what fails is named."""

import io
import json
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from foggy_synscapes.errors import UNFORESEEN, FoggyError

LARGEST = 512 << 20
"""Bytes of a file that is read as a whole; 100 megapixels of depth have 400 million."""
LARGEST_JSON = 64 << 20
LARGEST_TABLE = 1 << 30
LARGEST_WEIGHTS = 8 << 30
LARGEST_OF_ALL = 256 << 30
"""Bytes of any file that is opened: one of more (of zeros that take no room) would be hashed for hours."""

_KINDS = {
    stat.S_IFIFO: "a FIFO", stat.S_IFSOCK: "a socket", stat.S_IFCHR: "a device", stat.S_IFBLK: "a device",
    stat.S_IFDIR: "a folder",
}  # fmt: skip


@contextmanager
def named(name: object, what: str, advice: str = "") -> Iterator[None]:
    """Let errors of the block say which file it was about: "NAME: not a readable WHAT: REASON. ADVICE".

    Raises FoggyError for what the operating system refuses and for content that no check foresaw.
    """
    try:
        yield
    except FileNotFoundError as error:
        raise FoggyError(f"{name}: missing{'. ' if advice else ''}{advice}") from error
    except (OSError, *UNFORESEEN) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else error
        if isinstance(error, LookupError | RecursionError):
            reason = f"{type(error).__name__}: {error}"
        raise FoggyError(f"{name}: not a readable {what}: {reason}. {advice}".rstrip()) from error


def open_plain(path: str | Path, what: str = "file", limit: int = LARGEST_OF_ALL) -> io.BufferedReader:
    """A plain file, opened for reading; what could wait for ever, such as a FIFO, is not opened.

    Raises OSError if the file is missing or not to be read, FoggyError if it is no plain file or has more bytes.
    """
    check_plain(path, what, limit)
    # Should it be exchanged meanwhile, opening does not wait.
    return open(path, "rb", opener=lambda name, flags: os.open(name, flags | os.O_NONBLOCK))


def check_plain(path: str | Path, what: str = "file", limit: int = LARGEST_OF_ALL) -> int:
    """Size in bytes of a file that can be read to its end; raises as `open_plain` does.

    For libraries that open files themselves.
    """
    status = os.stat(path)
    kind = stat.S_IFMT(status.st_mode)
    if kind != stat.S_IFREG:
        raise FoggyError(f"{path}: is {_KINDS.get(kind, 'no file')}, expected a plain file")
    if status.st_size > limit:
        raise FoggyError(f"{path}: more than {limit:,} bytes ({status.st_size:,}); that is no {what}")
    return status.st_size


def read_bytes(path: str | Path, what: str = "file", advice: str = "", limit: int = LARGEST) -> bytes:
    """Content of a plain file; `what` and `advice` for its errors, see `named`.

    Raises FoggyError if it is missing, no plain file, larger than `limit` bytes, or being written.
    """
    with named(path, what, advice), open_plain(path, what, limit) as file:
        size = os.fstat(file.fileno()).st_size
        data = file.read(size + 1)  # one more: files of the system claim 0 bytes and have no end
        if len(data) != size:
            raise FoggyError(
                f"{path}: its size changes while it is read, expected {size:,} bytes. Is it being written?"
            )
    return data


def read_json(path: str | Path, what: str = "JSON file", advice: str = "", limit: int = LARGEST_JSON) -> Any:
    """What a JSON file holds; see `parse_json` and `read_bytes`."""
    return parse_json(read_bytes(path, what, advice, limit), path, what, advice)


def parse_json(data: bytes, name: object, what: str = "JSON file", advice: str = "") -> Any:
    """What JSON text in UTF-8 holds; FoggyError, calling it `name`, if it is none or has a key twice in an object."""
    with named(name, what, advice):
        return json.loads(data.decode("utf-8-sig"), object_pairs_hook=_once)


def number(value: object) -> float:
    """A number as JSON has it; ValueError for a boolean, a text, or what is not finite."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < float("inf"):
        raise ValueError(f"{value!r}, expected a finite number")
    return float(value)


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) != len(pairs):
        keys = [key for key, _ in pairs]
        raise ValueError(f"key {next(key for key in keys if keys.count(key) > 1)!r} stands twice")
    return found


def check_name(name: str) -> None:
    """Raise ValueError for the name of a file, from a file, that is absolute, empty or climbs out of its folder.

    >>> check_name("img/rgb/1.png")
    """
    parts = name.split("/")
    if not name or name.startswith("/") or set(name) & {"\\", "\0"} or any(part in ("", ".", "..") for part in parts):
        raise ValueError(f"unsafe member name {name!r}")
