"""List files of the datasets: one relative path a line."""

from collections.abc import Mapping
from pathlib import Path

from foggy_synscapes.datasets.index import expect
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.hashing import checked
from foggy_synscapes.scoring.pairing import frame


def read_text(root: Path, name: str, index: Mapping[str, str] | None = None) -> str:
    """Text of a list file below a dataset's root.

    Where the dataset's index (SHA-256 by path) is given, the content must be the listed one.

    Raises
    ------
    FoggyError
        If the file is missing, no text, not in the index, or not as listed there.
    """
    path = root / name
    try:
        data = path.read_bytes()
        if index is not None:
            expect(index, [name], root.name)
            data = checked(data, index[name], str(path))
        return data.decode("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise FoggyError(
            f"{path}: the list file cannot be read: {error}. The dataset's own lists "
            "are needed; scenes.refined_list names that of Foggy Cityscapes."
        ) from error


def read_list(root: Path, name: str, index: Mapping[str, str] | None = None) -> list[str]:
    """Paths of a list file, in its order; see `read_text`.

    Raises
    ------
    FoggyError
        Also if the list is empty, names a file twice, or a line is absolute or climbs out with `..`.
    """
    path, text = root / name, read_text(root, name, index)
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    for number, line in enumerate(lines, start=1):
        if line.startswith("/") or "\\" in line or ".." in line.split("/"):
            raise FoggyError(f"{path}, line {number}: {line[:80]!r} leads out of the dataset's folder")
        if line in lines[: number - 1]:
            raise FoggyError(f"{path}, line {number}: {line[:80]!r} stands there twice")
    if not lines:
        raise FoggyError(f"{path}: names no file")
    return lines


def paired(images: list[str], labels: list[str], name: str) -> list[tuple[str, str]]:
    """Pair two lists line by line; FoggyError if their lengths differ or a line names two frames."""
    if len(images) != len(labels):
        raise FoggyError(f"{name}: its lists name {len(images)} images but {len(labels)} label maps")
    for number, (image, label) in enumerate(zip(images, labels, strict=True), start=1):
        if Path(frame(image)).name != Path(frame(label)).name:
            raise FoggyError(f"{name}: line {number} of its lists names {image}, but labels of another frame: {label}")
    return list(zip(images, labels, strict=True))
