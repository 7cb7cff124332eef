"""List files of the test sets: one relative path a line."""

from pathlib import Path

from foggy_synscapes.errors import FoggyError


def read_list(path: str | Path) -> list[str]:
    """Paths of a list file, in its order.

    Raises
    ------
    FoggyError
        If the file is missing or empty, or a line is absolute or climbs out with `..`.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise FoggyError(
            f"{path}: the list file cannot be read: {error}. The dataset's own lists are needed."
        ) from error
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    for number, line in enumerate(lines, start=1):
        if line.startswith("/") or "\\" in line or ".." in line.split("/"):
            raise FoggyError(f"{path}, line {number}: {line[:80]!r} leads out of the dataset's folder")
    if not lines:
        raise FoggyError(f"{path}: names no file")
    return lines


def paired(images: list[str], labels: list[str], name: str) -> list[tuple[str, str]]:
    """Pair two lists line by line; FoggyError if their lengths differ."""
    if len(images) != len(labels):
        raise FoggyError(f"{name}: its lists name {len(images)} images but {len(labels)} label maps")
    return list(zip(images, labels, strict=True))
