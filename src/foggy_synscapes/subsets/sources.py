"""What lists are made from, as files; the rest of this package knows no path."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from foggy_synscapes.datasets.index import read_index
from foggy_synscapes.io.shards import read_manifest
from foggy_synscapes.io.tables import read_csv


class Sources:
    """Reads what lists are made from.

    inputs : gives the files that a job reads, by the name of a dataset, "kept" or "fog"
    roots : folder of each dataset; scenes : the params section

    Each method raises FoggyError where a file is missing or damaged.
    """

    def __init__(self, inputs: Callable[[str], list[Path]], roots: Mapping[str, Path], scenes: Any) -> None:
        self._inputs, self.roots, self.scenes = inputs, roots, scenes

    def index(self, dataset: str) -> dict[str, str]:
        """SHA-256 by path of a dataset's files."""
        return read_index(*self._inputs(dataset))

    def kept(self) -> list[int]:
        """Ids of the frames that the filter kept."""
        (path,) = self._inputs("kept")
        return [int(line["id"]) for line in read_csv(path, ("id",))]

    def foggy(self) -> dict[str, tuple[str, str]]:
        """Shard and SHA-256 by name of each foggy image, or of its recipe, at the beta of the list."""
        return {
            member.name: (path.stem, member.sha256) for path in self._inputs("fog") for member in read_manifest(path)
        }
