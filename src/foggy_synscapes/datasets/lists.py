"""List files of the datasets: one relative path a line."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from foggy_synscapes.datasets.dataset import Dataset, Incomplete
from foggy_synscapes.datasets.index import expect
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.files import named, read_bytes
from foggy_synscapes.io.hashing import checked
from foggy_synscapes.scoring.pairing import frame

LARGEST_LIST = 16 << 20  # bytes; the lists of the datasets have some ten thousand


def read_text(root: Path, name: str, index: Mapping[str, str] | None = None) -> str:
    """Text of a list file below a dataset's root.

    Where the dataset's index (SHA-256 by path) is given, the content must be the listed one.

    Raises
    ------
    FoggyError
        If the file is missing, no text, not in the index, or not as listed there.
    """
    path, advice = root / name, "The dataset's own lists are needed."
    if not path.is_file():
        raise Incomplete(f"{path}: missing. {advice}", name)
    data = read_bytes(path, "list file", advice, LARGEST_LIST)
    if index is not None:
        expect(index, [name], root.name)
        checked(data, index[name], str(path))
    with named(path, "list file", advice):
        return data.decode("utf-8")


def read_list(root: Path, name: str, index: Mapping[str, str] | None = None) -> list[str]:
    """Paths of a list file, in its order; see `read_text`.

    Raises
    ------
    FoggyError
        Also if the list is empty, names a file twice, or a line is absolute or climbs out with `..`.
    """
    path, text = root / name, read_text(root, name, index)
    lines: dict[str, int] = {}
    for number, line in enumerate(map(str.strip, text.split("\n")), start=1):
        if line.startswith("/") or set(line) & {"\\", "\0"} or ".." in line.split("/"):
            raise FoggyError(f"{path}, line {number}: {line[:80]!r} leads out of the dataset's folder")
        if line and lines.setdefault(line, number) != number:
            raise FoggyError(f"{path}, line {number}: {line[:80]!r} stands there twice")
    if not lines:
        raise FoggyError(f"{path}: names no file")
    return list(lines)


def paired(images: list[str], labels: list[str], name: str) -> list[tuple[str, str]]:
    """Pair two lists line by line; FoggyError if their lengths differ or a line names two frames."""
    if len(images) != len(labels):
        raise FoggyError(f"{name}: its lists name {len(images)} images but {len(labels)} label maps")
    for number, (image, label) in enumerate(zip(images, labels, strict=True), start=1):
        if frame(image).split("/")[1:] != frame(label).split("/")[1:]:
            raise FoggyError(f"{name}: line {number} of its lists names {image}, but labels of another frame: {label}")
    return list(zip(images, labels, strict=True))


def listed(
    title: str, short_title: str, lists: Callable[[Any], tuple[str, str]], settings: tuple[str, ...] = (), **about: Any
) -> Dataset:
    """A dataset of test images that two lists of its own pair with their labelIds.

    lists : paths below the root, of the images' list and of the label maps', by the params section scenes
    about : further fields of `Dataset`
    """

    def pairs(root: Path, index: Mapping[str, str] | None, scenes: Any) -> list[tuple[str, str]]:
        images, labels = (read_list(root, name, index) for name in lists(scenes))
        return sorted(paired(images, labels, short_title))

    def files(root: Path, scenes: Any, _part: str) -> list[str]:
        return [*lists(scenes), *(path for pair in pairs(root, None, scenes) for path in pair)]

    return Dataset(title, short_title, files, settings=settings, test_pairs=pairs, **about)
