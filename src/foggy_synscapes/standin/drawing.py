"""Drawing a stand-in to its folder: only what is not there already, by several processes, and nothing else stays."""

import json
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from foggy_synscapes.io.atomic import write_bytes, write_text
from foggy_synscapes.io.hashing import sha256
from foggy_synscapes.io.images import encode_depth, encode_png
from foggy_synscapes.io.processes import in_processes
from foggy_synscapes.io.progress import progress
from foggy_synscapes.io.stamps import stamp
from foggy_synscapes.standin.layouts.layout import Files, Frame

CHECKPOINT = 100  # frames after which the record of what is made is saved


class Made:
    """Which files an earlier, perhaps interrupted, run has made and nobody has touched since.

    path : its record; folder : in which the files are; fingerprint : of what they are made by
    """

    def __init__(self, path: Path, fingerprint: str, folder: Path) -> None:
        self.path, self.fingerprint, self.folder = path, fingerprint, folder
        self.files: dict[str, tuple[list[int], str]] = {}
        # The record only saves time: one that cannot be read, or of other params, is as good as none.
        try:
            document = json.loads(path.read_text(encoding="utf-8"))
            if document["fingerprint"] == fingerprint:
                self.files = {path: (known, digest) for path, (known, digest) in document["files"].items()}
        except (OSError, ValueError, KeyError, TypeError):
            pass

    def has(self, paths: Iterable[str]) -> bool:
        """Whether all of these files are there as they were made."""
        return all(path in self.files and self._is_as_made(path) for path in paths)

    def add(self, paths: Iterable[str]) -> None:
        """Take these files, as they are now, for made."""
        self.files.update((path, (stamp(self.folder / path), sha256(self.folder / path))) for path in paths)

    def save(self) -> None:
        """Write the record."""
        write_text(self.path, json.dumps({"fingerprint": self.fingerprint, "files": self.files}))

    def _is_as_made(self, path: str) -> bool:
        (known, digest), now = self.files[path], stamp(self.folder / path)
        return bool(now) and (now == known or sha256(self.folder / path) == digest)


def draw(frames: Sequence[Frame], lists: Files, made: Made, readme: Path, jobs: int, what: str) -> None:
    """Write every file of frames and lists to the folder of `made`, and remove what is neither of them nor `readme`.

    jobs : processes that render; what : a word for the progress shown
    """
    folder, waiting = made.folder, [frame for frame in frames if not made.has(frame.paths)]
    for number, files in enumerate(progress(_rendered(waiting, jobs), what, total=len(waiting)), start=1):
        for path, data in files:
            write_bytes(folder / path, data)
        made.add([path for path, _ in files])
        if number % CHECKPOINT == 0:
            made.save()
    made.save()
    for path, data in lists:
        write_bytes(folder / path, data)
    paths = [path for frame in frames for path in frame.paths] + [path for path, _ in lists]
    wanted = {readme, *(folder / path for path in paths)}
    for found in sorted(folder.rglob("*")):
        if found.is_file() and found not in wanted:
            found.unlink()


def encode(path: str, content: np.ndarray | dict[str, Any]) -> bytes:
    """Bytes of a file: of an array by the ending of its name, PNG or EXR; of a mapping as JSON."""
    if isinstance(content, dict):
        return (json.dumps(content, indent=1, sort_keys=True) + "\n").encode()
    return encode_depth(content) if path.endswith(".exr") else encode_png(content)


def _rendered(frames: list[Frame], jobs: int) -> Iterator[list[tuple[str, bytes]]]:
    yield from in_processes(_files, frames, min(jobs, len(frames)), lambda frame: frame.paths[0])


def _files(frame: Frame) -> list[tuple[str, bytes]]:
    return [(path, encode(path, content)) for path, content in zip(frame.paths, frame.render(*frame.key), strict=True)]
