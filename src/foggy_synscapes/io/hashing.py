"""Content hashes."""

import hashlib
from pathlib import Path

from foggy_synscapes.errors import FoggyError


def sha256(path: str | Path) -> str:
    """SHA-256 of a file's bytes in hexadecimal, read in pieces."""
    try:
        with open(path, "rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise FoggyError(f"{path}: cannot be read: {error.strerror}") from error


def sha256_bytes(data: bytes | memoryview) -> str:
    """SHA-256 of bytes in hexadecimal."""
    return hashlib.sha256(data).hexdigest()


def read_checked(path: str | Path, expected: str) -> bytes:
    """Read a file and make sure that its SHA-256 is the expected one.

    Raises
    ------
    FoggyError
        If the file cannot be read, or its content is not what was listed.
    """
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise FoggyError(f"{path}: cannot be read: {error.strerror}. It was there when it was listed.") from error
    return checked(data, expected, str(path))


def checked(data: bytes, expected: str, name: str) -> bytes:
    """Return `data` if its SHA-256 is the expected one; raise FoggyError that names it otherwise."""
    if sha256_bytes(data) != expected:
        raise FoggyError(
            f"{name}: its content changed since it was listed (sha256 is not {expected[:12]}...). "
            "Restore the file, or list it anew by `foggy scenes` and run the pipeline again."
        )
    return data
