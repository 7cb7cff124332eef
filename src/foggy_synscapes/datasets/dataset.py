"""What a dataset declares: its titles, and which of the files below its root belong to it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from foggy_synscapes.errors import FoggyError

STAND_IN = "stand-in"
"""What stands in `scenes.roots` in place of a folder where a dataset is drawn."""


class Incomplete(FoggyError):
    """A file of a dataset is missing. path : its path below the dataset's root"""

    def __init__(self, message: str, path: str) -> None:
        super().__init__(message)
        self.path = path


@dataclass(frozen=True)
class Dataset:
    """A dataset on disk. Its functions are given the params section `scenes`, which holds its settings.

    title : as tables print it; short_title : as figures print it
    files : (root, scenes, part) -> paths below the root that one of its indexes lists; FoggyError, naming a file or a
        key, where a list of the dataset is missing or wrong, or a frame is not complete
    parts : params key that lists the names of its indexes, where it has one for each shard
    settings : dotted keys of the params that decide, beside its root, which files it has
    test_pairs : (root, index, scenes) -> sorted (image, labelIds) paths below the root, where networks are tested on
        it; the index, SHA-256 by path, vouches for its list files
    pixels : of an image at full size, for estimates; 0 where nobody says
    tests : scenes -> number of its test images at full size, for estimates
    folders : those below its root, as its archives unpack; home : which archives they are, and of which site, for
        messages about a root that lacks them
    """

    title: str
    short_title: str
    files: Callable[[Path, Any, str], list[str]]
    parts: str = ""
    settings: tuple[str, ...] = ()
    test_pairs: Callable[[Path, Mapping[str, str], Any], list[tuple[str, str]]] | None = None
    pixels: int = 0
    tests: Callable[[Any], int] = lambda _scenes: 0
    folders: tuple[str, ...] = ()
    home: str = ""

    def tested(self, root: Path, index: Mapping[str, str], scenes: Any) -> list[tuple[str, str]]:
        """What `test_pairs` gives; FoggyError where networks are not tested on this dataset."""
        if self.test_pairs is None:
            raise FoggyError(f"{self.title}: has no test images")
        return self.test_pairs(root, index, scenes)
