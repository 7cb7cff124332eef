"""Shards: many images in one uncompressed USTAR file, the same bytes for the same members.

Members are sorted by name, without time, owner or rights of the machine that wrote them; any tar program
and WebDataset read them. Beside a shard lies its manifest, a CSV of name, size and SHA-256 per member.
"""

import io
import tarfile
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.atomic import replacing
from foggy_synscapes.io.hashing import sha256_bytes
from foggy_synscapes.io.names import check_name
from foggy_synscapes.io.tables import read_csv, write_csv

COLUMNS = ("name", "size", "sha256")


@dataclass(frozen=True)
class Member:
    """One line of a manifest: member name, size in bytes, SHA-256 in hexadecimal."""

    name: str
    size: int
    sha256: str


def write_shard(path: str | Path, members: Iterable[tuple[str, bytes]]) -> list[Member]:
    """Write (name, bytes) pairs, which must come sorted by name, and return their manifest.

    Only one member is held in memory at a time.

    Raises
    ------
    ValueError
        If names are not strictly ascending, or leave the folder they are unpacked to.
    """
    manifest: list[Member] = []
    with replacing(path) as file, tarfile.open(fileobj=file, mode="w", format=tarfile.USTAR_FORMAT) as tar:
        for name, data in members:
            check_name(name)
            if manifest and name <= manifest[-1].name:
                raise ValueError(f"shard members must be sorted by name: {name} after {manifest[-1].name}")
            entry = tarfile.TarInfo(name)
            entry.size, entry.mode = len(data), 0o644
            tar.addfile(entry, io.BytesIO(data))
            manifest.append(Member(name, len(data), sha256_bytes(data)))
    return manifest


class Shard:
    """Random access to the members of a shard.

    Raises
    ------
    FoggyError
        If the file is missing, is no tar file, is cut off, or holds anything but plain files.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        try:
            self._file = open(self.path, "rb")  # noqa: SIM115 (held open for reading members)
        except OSError as error:
            raise FoggyError(f"{path}: cannot be read: {error.strerror}. Make the shard again by its step.") from error
        try:
            with tarfile.open(fileobj=self._file, mode="r:") as tar:
                entries = tar.getmembers()
            for entry in entries:
                check_name(entry.name)
            if not all(entry.isreg() for entry in entries):
                raise ValueError("holds links or folders, expected plain files only")
        except (tarfile.TarError, ValueError) as error:
            self._file.close()
            raise FoggyError(f"{path}: not a shard: {error}. Delete it and run its step again.") from error
        self._places = {entry.name: (entry.offset_data, entry.size) for entry in entries}

    def names(self) -> list[str]:
        """Names of the members, in the order of the file."""
        return list(self._places)

    def read(self, name: str) -> bytes:
        """Bytes of one member."""
        if name not in self._places:
            raise FoggyError(f"{self.path}: no member {name}; it has {len(self._places)}")
        offset, size = self._places[name]
        self._file.seek(offset)
        data = self._file.read(size)
        if len(data) != size:
            raise FoggyError(f"{self.path}: cut off within {name}. Delete it and run its step again.")
        return data

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def __enter__(self) -> "Shard":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def write_manifest(path: str | Path, members: Iterable[Member]) -> None:
    """Write name, size and SHA-256 of each member as CSV."""
    write_csv(path, COLUMNS, ((member.name, member.size, member.sha256) for member in members))


def read_manifest(path: str | Path) -> list[Member]:
    """Read a manifest; names that would leave their folder are refused with FoggyError."""
    members = [Member(row["name"], int(row["size"]), row["sha256"]) for row in read_csv(path, COLUMNS)]
    for member in members:
        try:
            check_name(member.name)
        except ValueError as error:
            raise FoggyError(f"{path}: {error}") from error
    return members
