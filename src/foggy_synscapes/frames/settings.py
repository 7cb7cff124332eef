"""What the images of one folder were made with: written with the first image, the same for all that follow."""

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io import lock
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.files import read_json

NAME = "settings.json"
CHANGED = {
    "code": "the code that renders fog is another version",
    "camera": "the file of the camera has other content",
}
"""What is said where two digests differ, which tell a reader nothing."""


def text(settings: Mapping[str, Any]) -> str:
    """Settings as the file states them."""
    return json.dumps(settings, indent=1) + "\n"


def check(folder: Path, wanted: str, images: str) -> None:
    """Keep one folder from holding images of different frames, settings or versions of the code.

    wanted : settings as `text` gives them; images : pattern of what images below the folder are called

    Raises FoggyError that says what differs, or that nothing tells how the images that are there were made.
    """
    path = folder / NAME
    if os.path.lexists(path):
        _compare(path, wanted)
    elif any(folder.glob(images)):
        raise FoggyError(
            f"{path}: missing, so nothing tells how the images beside it were made. Choose another --out, or "
            "delete the folder."
        )


def claim(folder: Path, wanted: str) -> None:
    """Have a folder state its settings before its first image is written, whoever writes it.

    Raises FoggyError as `check` does, where another process stated others meanwhile.
    """
    path = folder / NAME
    if not os.path.lexists(path):
        with lock.of_folder(folder):
            if not os.path.lexists(path):
                write_text(path, wanted)
    _compare(path, wanted)


def _compare(path: Path, wanted: str) -> None:
    before, now = read_json(path, "file of settings", "Delete the folder, or choose another --out."), json.loads(wanted)
    if not isinstance(before, dict):
        raise FoggyError(f"{path}: not a readable file of settings. Delete the folder, or choose another --out.")
    if before != now:
        keys = sorted(key for key in {*before, *now} if before.get(key) != now.get(key))
        differences = "; ".join(_in_words(key, before.get(key), now.get(key)) for key in keys)
        raise FoggyError(
            f"{path}: the folder holds images that were made otherwise: {differences}. Choose another --out, or "
            "delete the folder."
        )


def _in_words(key: str, before: Any, now: Any) -> str:
    """One difference, without digests.

    >>> _in_words("geometry", "paper", "exact")
    'geometry was paper, now exact'
    >>> _in_words("camera", "one file, 0123456789abcdef", "meta files")
    'camera was one file, now meta files'
    >>> _in_words("camera", "one file, 0123456789abcdef", "one file, 123456789abcdef0")
    'the file of the camera has other content'
    """
    kinds = [str(value).partition(",")[0] for value in (before, now)]
    if key in CHANGED and (key == "code" or kinds[0] == kinds[1]):
        return CHANGED[key]
    if key == "foggy_synscapes":
        return f"by version {before} of this program, now {now}"
    first, second = kinds if key == "camera" else ["not stated" if v is None else v for v in (before, now)]
    return f"{key} was {first}, now {second}"
