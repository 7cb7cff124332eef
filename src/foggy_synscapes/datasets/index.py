"""Indexes: which files a dataset consists of, and their content hashes.

The engines see raw data, stand-in or real, through these small tables (path, size in bytes, SHA-256), never through
the folders themselves. Paths are relative to the dataset's root, with forward slashes.
"""

from collections.abc import Iterable, Mapping
from pathlib import Path

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.checksums import Checksums
from foggy_synscapes.io.files import LARGEST, check_name, check_plain, named
from foggy_synscapes.io.hashing import sha256_bytes
from foggy_synscapes.io.progress import progress
from foggy_synscapes.io.stamps import CACHE, Stamps
from foggy_synscapes.io.tables import csv_text, read_csv, write_csv

COLUMNS = ("path", "size", "sha256")


def read_index(*paths: Path) -> dict[str, str]:
    """SHA-256 by relative path, of one index or of several, which are the parts of a dataset.

    Raises FoggyError if an index is missing or damaged, or names a file outside of the dataset's folder.
    """
    hashes: dict[str, str] = {}
    for path in paths:
        with named(path, "index"):
            for row in read_csv(path, COLUMNS):
                check_name(row["path"])
                hashes[row["path"]] = row["sha256"]
    return hashes


def write_index(index: Path, root: Path, paths: Iterable[str], checksums: Checksums | None = None) -> None:
    """Hash the files and write their index, `DATASET/PART.csv`, sorted by path.

    A file whose stamp is that of the last time is not read again.

    checksums : what the files have to be, by whoever made the dataset

    Raises
    ------
    FoggyError
        If a file is missing, is not a plain file of at most 512 MiB, lies outside the root (through `..` or a link), or
        is not as `checksums` say.
    """
    write_csv(index, COLUMNS, _rows(index, root, paths, checksums))


def index_digest(index: Path, root: Path, paths: Iterable[str]) -> str:
    """SHA-256 of the index that `write_index` would write of the files as they are now; it raises the same errors."""
    return sha256_bytes(csv_text(COLUMNS, _rows(index, root, paths, None)).encode())


def _rows(index: Path, root: Path, paths: Iterable[str], checksums: Checksums | None) -> list[tuple[str, int, str]]:
    name, stamps, rows = f"{index.parent.name}/{index.stem}", _stamps_of(index), []
    inside = root.resolve()
    for path in progress(sorted(paths), f"index {name}", unit="file"):
        file = root / path
        if not file.is_file():
            raise FoggyError(
                f"{file}: missing. The {index.parent.name} dataset is incomplete; see the README on real data."
            )
        if not file.resolve().is_relative_to(inside):
            raise FoggyError(f"{file}: leads out of the dataset's folder. Copy the file in instead of linking it.")
        check_plain(file, "file of a dataset", LARGEST)
        digest = stamps.sha256(file)
        if checksums is not None and digest != (wanted := checksums.of(file)):
            raise FoggyError(f"{file}: its sha256 is {digest[:12]}..., but {checksums.path} has {wanted[:12]}...")
        rows.append((path, file.stat().st_size, digest))
    stamps.save()
    return rows


def changed_since_listed(index: Path, root: Path) -> list[str]:
    """Files of an index that are missing or have another content than when they were listed.

    Only files whose stamp is another than the last time are read. An index that was not made on this machine cannot
    be judged so and gives []; `foggy verify --data` reads all that it lists.
    """
    stamps = _stamps_of(index)
    if not stamps.path.is_file():
        return []
    try:
        listed = read_index(index)
    except FoggyError:
        return []  # an index that is missing or damaged is made again
    changed = [path for path, digest in listed.items() if stamps.state(root / path, digest) != "unchanged"]
    stamps.save()
    return changed


def _stamps_of(index: Path) -> Stamps:
    return Stamps(CACHE / index.parent.name / f"{index.stem}.json")


def expect(index: Mapping[str, str], paths: Iterable[str], dataset: str) -> None:
    """Raise FoggyError naming the first of `paths` that an index does not have."""
    for path in paths:
        if path not in index:
            raise FoggyError(f"{dataset}: {path} is not in its index. Is the file missing? Run `foggy scenes` again.")
