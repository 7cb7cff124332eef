"""Indexes: which files a dataset consists of, and their content hashes.

The engines see raw data, stand-in or real, through these small tables (path, size in bytes, SHA-256), never through
the folders themselves. Paths are relative to the dataset's root, with forward slashes.
"""

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.checksums import Checksums
from foggy_synscapes.io.files import LARGEST, check_name, check_plain, named, read_json
from foggy_synscapes.io.hashing import sha256
from foggy_synscapes.io.progress import progress
from foggy_synscapes.io.tables import read_csv, write_csv

COLUMNS = ("path", "size", "sha256")
CACHE = Path(".foggy/cache")
"""What only saves time, and knows the times of this machine's files: not a result."""


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

    A file whose size and modification time are those of the last time is not read again.

    checksums : what the files have to be, by whoever made the dataset

    Raises
    ------
    FoggyError
        If a file is missing, is not a plain file of at most 512 MiB, lies outside the root (through `..` or a link), or
        is not as `checksums` say.
    """
    name, cache_path = f"{index.parent.name}/{index.stem}", _cache_path(index)
    cache = read_cache(cache_path)
    rows, fresh = [], {}
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
        found = stamp(file)
        known = cache.get(path)
        digest = known[1] if known and known[0] == found else sha256(file)
        if checksums is not None and digest != (wanted := checksums.of(file)):
            raise FoggyError(f"{file}: its sha256 is {digest[:12]}..., but {checksums.path} has {wanted[:12]}...")
        fresh[path] = [found, digest]
        rows.append((path, found[0], digest))
    write_csv(index, COLUMNS, rows)
    write_text(cache_path, json.dumps(fresh))


def changed_since_listed(index: Path, root: Path) -> list[str]:
    """Files of an index that are missing or have another content than when they were listed.

    Only files whose size or modification time is another are read. An index that was not made on this machine cannot
    be judged so and gives [].
    """
    cache_path = _cache_path(index)
    cache = read_cache(cache_path) if index.is_file() else {}
    changed, touched = [], False
    for path, (listed, digest) in sorted(cache.items()):
        found = stamp(root / path)
        # Not the inode: a copy of the folder that kept its times is as good.
        if found[:2] == listed[:2]:
            continue
        if found[:1] != listed[:1] or sha256(root / path) != digest:
            changed.append(path)
        else:
            cache[path], touched = [found, digest], True
    if touched:
        write_text(cache_path, json.dumps(cache))
    return changed


def _cache_path(index: Path) -> Path:
    return CACHE / index.parent.name / f"{index.stem}.json"


def stamp(file: Path) -> list[int]:
    """Size in bytes, modification time in ns and inode; empty where the file is missing."""
    try:
        status = file.stat()
    except OSError:
        return []
    return [status.st_size, status.st_mtime_ns, status.st_ino]


def read_cache(path: Path) -> dict[str, Any]:
    """Content of a file below `CACHE`. It only saves time: one that cannot be read is as good as an empty one."""
    try:
        cache = read_json(path)
    except FoggyError:
        return {}
    return cache if isinstance(cache, dict) else {}


def expect(index: Mapping[str, str], paths: Iterable[str], dataset: str) -> None:
    """Raise FoggyError naming the first of `paths` that an index does not have."""
    for path in paths:
        if path not in index:
            raise FoggyError(f"{dataset}: {path} is not in its index. Is the file missing? Run `foggy scenes` again.")
