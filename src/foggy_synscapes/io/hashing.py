"""Content hashes."""

import hashlib
from pathlib import Path

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.files import named, open_plain, read_bytes


def sha256(path: str | Path) -> str:
    """SHA-256 of a plain file's bytes in hexadecimal, read in pieces."""
    with named(path, "file"), open_plain(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def sha256_bytes(data: bytes | memoryview) -> str:
    """SHA-256 of bytes in hexadecimal."""
    return hashlib.sha256(data).hexdigest()


def read_checked(path: str | Path, expected: str) -> bytes:
    """Read a file and make sure that its SHA-256 is the expected one; FoggyError if it is not, or cannot be read."""
    return checked(read_bytes(path, advice="It was there when it was listed."), expected, str(path))


def checked(data: bytes, expected: str, name: str) -> bytes:
    """Return `data` if its SHA-256 is the expected one; raise FoggyError that names it otherwise."""
    if sha256_bytes(data) != expected:
        raise FoggyError(
            f"{name}: its content changed since it was listed (sha256 is not {expected[:12]}...). "
            "Restore the file, or list it anew by `foggy scenes` and run the pipeline again."
        )
    return data
