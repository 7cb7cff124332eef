"""Checksums that someone else made, in the format of `sha256sum`: for files whose own format has none."""

import re
from pathlib import Path

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.files import LARGEST_TABLE, named, read_bytes

_LINE = re.compile(r"(\\?)([0-9a-fA-F]{64}) [ *](.+)")
_ESCAPES = {"\\\\": "\\", "\\n": "\n", "\\r": "\r"}


class Checksums:
    """SHA-256 of files by their path; those of a list are relative to the folder that it lies in.

    Raises FoggyError if the list is missing, or a line is not one of `sha256sum`.
    """

    def __init__(self, path: str | Path) -> None:
        self.path, self._known = Path(path), {}
        with named(path, "list of checksums"):
            text = read_bytes(path, "list of checksums", limit=LARGEST_TABLE).decode("utf-8", "surrogateescape")
        folder = self.path.resolve().parent
        for number, line in enumerate(text.splitlines(), start=1):
            match = _LINE.fullmatch(line)
            if match is None:
                raise FoggyError(
                    f"{path}, line {number}: {line[:80]!r} is not as sha256sum writes it: SHA-256, two spaces, path"
                )
            escaped, digest, name = match.groups()
            if escaped:
                name = re.sub(r"\\[\\nr]", lambda found: _ESCAPES[found[0]], name)
            self._known[folder / name] = digest.lower()

    def of(self, path: Path) -> str:
        """The listed SHA-256 of a file; FoggyError if it is not listed."""
        digest = self._known.get(path.absolute()) or self._known.get(path.resolve())
        if digest is None:
            raise FoggyError(f"{path}: not in {self.path}. List it too: sha256sum {path.name}")
        return digest
