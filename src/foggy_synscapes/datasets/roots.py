"""Why a folder is not the dataset that it should be: what is missing, what is there instead, where the rest is.

Archives are unpacked in part, into one another or one folder too deep; copies change names.
"""

import difflib
import os
from pathlib import Path
from typing import Any

from foggy_synscapes.datasets import DATASETS
from foggy_synscapes.datasets.dataset import STAND_IN, Incomplete
from foggy_synscapes.errors import FoggyError

SHOWN = 3
"""Names of a folder that a message shows."""
ARCHIVES = (".zip", ".tar", ".tar.gz", ".tgz", ".7z", ".rar")


def files_of(name: str, root: Path, scenes: Any, part: str) -> list[str]:
    """Paths below a real root that an index of a dataset lists, sorted.

    Raises
    ------
    FoggyError
        If the root is no folder, if a list or a file is missing or empty, or as `Dataset.files` does. The message says
        what is there instead, what was expected, and where to get it.
    """
    entry = DATASETS[name]
    if not root.is_dir():
        raise FoggyError(
            f"scenes.roots.{name}: {root} is no folder. {_beside(root)}"
            f"Give the dataset's folder, or {STAND_IN!r}. {expected(name)}"
        )
    try:
        paths = sorted(set(entry.files(root, scenes, part)))
    except FoggyError as error:
        path = error.path if isinstance(error, Incomplete) else ""
        raise FoggyError(f"{error} {_as_a_whole(name, root) or instead(root, path)}{expected(name)}") from error
    absent = [path for path in paths if not _has_content(root / path)]
    if absent:
        first = absent[0]
        what = "is empty; was unpacking cut off?" if (root / first).is_file() else "missing."
        count = f"It is the first of {len(absent)} among {len(paths)} files. " if len(absent) > 1 else ""
        raise FoggyError(
            f"{root / first}: {what} {count}{_as_a_whole(name, root) or instead(root, first)}{expected(name)}"
        )
    return paths


def expected(name: str) -> str:
    """One sentence: which folders a root of a dataset has, and where to get them; "" if the dataset does not say."""
    entry = DATASETS[name]
    if not entry.folders:
        return ""
    *others, last = entry.folders
    folders = f"the folders {', '.join(others)} and {last}" if others else f"the folder {last}"
    return f"A root of {name} has {folders}" + (f", from {entry.home}." if entry.home else ".")


def instead(root: Path, path: str) -> str:
    """What a folder holds where the first missing part of a path should be; "" if all parts are there."""
    place = root
    for part in Path(path).parts:
        if (place / part).exists():
            place /= part
            continue
        names = _names(place)
        alike = [name for name in names if name.lower() == part.lower()]
        alike = alike or [name for name in names if Path(name).stem.lower() == Path(part).stem.lower()]
        if alike:
            return f"There is {alike[0]!r} where {part!r} is expected, and names count letter by letter. "
        shown = ", ".join(names[:SHOWN]) + (f" and {len(names) - SHOWN} more" if len(names) > SHOWN else "")
        return f"Instead of {part}, {place} holds {shown or 'nothing'}. "
    return ""


def _as_a_whole(name: str, root: Path) -> str:
    """One sentence on a root that lacks folders of its dataset, or has those of another one."""
    folders = DATASETS[name].folders
    there = {folder for folder in folders if (root / folder).is_dir()}
    lacking = [folder for folder in folders if folder not in there]
    # Several datasets may lie in one folder: another one is meant only if it explains all that is there of this one.
    others = [other for other in _whole(root) if there <= set(DATASETS[other].folders) and other != name]
    if folders and others and (lacking or folders != DATASETS[others[0]].folders):
        return f"This looks like {others[0]}: is it named in the wrong place of scenes.roots? "
    if not lacking:
        return ""
    inner = [path for path in map(root.joinpath, _names(root)) if path.is_dir() and name in _whole(path)]
    for place in [*inner, root.parent]:
        if name in _whole(place):
            return f"The dataset is in {place}: name that folder in scenes.roots.{name}. "
    packed = [file for file in _names(root) if file.lower().endswith(ARCHIVES)]
    return f"{packed[0]} is there, but not unpacked. " if packed else instead(root, lacking[0])


def _whole(root: Path) -> list[str]:
    """Datasets of which a root has every folder, those with the most folders first."""
    folders = {name: DATASETS[name].folders for name in DATASETS}
    found = [name for name, own in folders.items() if own and all((root / folder).is_dir() for folder in own)]
    return sorted(found, key=lambda name: -len(folders[name]))


def _beside(root: Path) -> str:
    """One sentence on a file, or a folder of nearly this name, in place of a root that is no folder; else ""."""
    if root.is_file():
        return "It is a file: unpack it. " if root.name.lower().endswith(ARCHIVES) else "It is a file. "
    near = difflib.get_close_matches(root.name.lower(), [name.lower() for name in _names(root.parent)], 1, 0.8)
    alike = [name for name in _names(root.parent) if name.lower() in near]
    return f"Beside it is {alike[0]!r}. " if alike else ""


def _has_content(file: Path) -> bool:
    try:
        status = file.stat()
    except OSError:
        return False
    return status.st_size > 0 and file.is_file()


def _names(folder: Path) -> list[str]:
    """What a folder holds, sorted, without hidden names; [] if it cannot be read."""
    try:
        return sorted(name for name in os.listdir(folder) if not name.startswith("."))
    except OSError:
        return []
