"""Shards: many images in one uncompressed USTAR file, the same bytes for the same members.

Members are sorted by name, without time, owner or rights of the machine that wrote them; any tar program
and WebDataset read them. Beside a shard lies its manifest, a CSV of name, size and SHA-256 per member.
"""

import io
import tarfile
from collections.abc import Iterable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.atomic import replacing
from foggy_synscapes.io.files import LARGEST, check_name, named, open_plain
from foggy_synscapes.io.hashing import sha256_bytes
from foggy_synscapes.io.tables import read_csv, write_csv

COLUMNS = ("name", "size", "sha256")
_ADVICE = "Delete it and run its step again."


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
        with named(path, "shard", _ADVICE), ExitStack() as held:
            self._file = held.enter_context(open_plain(path))
            self._places = _places(self._file)
            held.pop_all()

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
            raise FoggyError(f"{self.path}: cut off within {name}. {_ADVICE}")
        return data

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def __enter__(self) -> "Shard":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _places(file: IO[bytes]) -> dict[str, tuple[int, int]]:
    """Offset and size in bytes of each member; ValueError where a shard has other than plain USTAR members, sorted."""
    places: dict[str, tuple[int, int]] = {}
    try:
        with tarfile.open(fileobj=_Headers(file), mode="r:") as tar:
            for entry in tar:
                check_name(entry.name)
                plain = entry.type in (tarfile.REGTYPE, tarfile.AREGTYPE)
                # One header of 512 bytes: longer ones are extensions, which may give other names and sizes.
                if not plain or tar.pax_headers or entry.offset_data - entry.offset != tarfile.BLOCKSIZE:
                    raise ValueError(f"{entry.name} is a link, a folder or of another kind, expected plain files only")
                if places and entry.name <= next(reversed(places)):
                    raise ValueError(f"member {entry.name} after {next(reversed(places))}, expected each once, sorted")
                if entry.size > LARGEST:
                    raise ValueError(f"member {entry.name} claims {entry.size:,} bytes")
                places[entry.name] = entry.offset_data, entry.size
    except tarfile.TarError as error:
        raise ValueError(error) from error
    return places


class _Headers(io.RawIOBase):
    """The headers of a tar file, which are read one by one: a longer piece is a header that lies."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        return self._file.seek(offset, whence)

    def tell(self) -> int:
        return self._file.tell()

    def read(self, size: int = -1) -> bytes:
        if not 0 <= size <= tarfile.RECORDSIZE:
            raise ValueError("holds a header that is longer than a shard's")
        return self._file.read(size)


def write_manifest(path: str | Path, members: Iterable[Member]) -> None:
    """Write name, size and SHA-256 of each member as CSV."""
    write_csv(path, COLUMNS, ((member.name, member.size, member.sha256) for member in members))


def read_manifest(path: str | Path) -> list[Member]:
    """Read a manifest; FoggyError if it is damaged, or a name would leave the folder that it is unpacked to."""
    rows = read_csv(path, COLUMNS)
    with named(path, "manifest"):
        for row in rows:
            check_name(row["name"])
        return [Member(row["name"], int(row["size"]), row["sha256"]) for row in rows]
