"""What a kind of list declares: its entries in the params, what it reads, and how its lists are made."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from foggy_synscapes.datasets.index import read_index
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.files import named
from foggy_synscapes.io.shards import read_manifest
from foggy_synscapes.io.tables import read_csv
from foggy_synscapes.schema import Beta, Section, setting

Line = tuple[str, str, str, str]
"""URI of an image, its SHA-256, URI of its label map, its SHA-256."""
Lists = tuple[list[Line], list[Line]]
"""The training and the validation list."""
FOG, MADE, COMPLETED, MODELLED = "fog", "made", "completed", "modelled"
"""In `Kind.reads`, each at the entry's beta: the kept frames and the shards of Foggy Synscapes; the shards of Foggy
Cityscapes made here; the kept frames and the shards of Foggy Synscapes of completed depth; and those by the fog model
that the entry names."""
IMAGES = {FOG, MADE, COMPLETED, MODELLED}


class Sources:
    """Reads what lists are made from; the rest of this package knows no path.

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
        with named(path, "table of frames"):
            return [int(line["id"]) for line in read_csv(path, ("id",))]

    def foggy(self, made: str = FOG) -> dict[str, tuple[str, str]]:
        """Shard and SHA-256 by name of each foggy image, or of its recipe, at the beta of the list.

        made : what is read, one of IMAGES
        """
        return {
            member.name: (path.stem, member.sha256) for path in self._inputs(made) for member in read_manifest(path)
        }


class Row(Section):
    """A list of images of one dataset."""

    inline = True

    train: int = setting("trained on", unit="images", ge=1)
    validation: int = setting("validated on", unit="images", ge=1)

    def counts(self) -> tuple[int, int]:
        """Number of entries of the training and of the validation list."""
        return self.train, self.validation


class FoggyRow(Row):
    """A list of images of one foggy dataset."""

    beta: Beta = setting("attenuation coefficient, quoted", unit="1/m")


class ModelledRow(FoggyRow):
    """A list of images of Foggy Synscapes by a fog model of its own."""

    model: str = setting("of fog, one of fog.also; its values are in fog.values")


@dataclass(frozen=True)
class Kind:
    """A kind of list.

    text : what its lists are, in a few words
    entry : model of an entry in the params section `subset`; a FoggyRow where one of IMAGES is
        read, a ModelledRow where MODELLED is
    reads : datasets whose indexes it reads, and IMAGES
    lists : (sources, entry, its dotted key in the params) -> lists; FoggyError if there is less than is asked for
    keys : dotted keys of params that it reads beside the entry
    order : place among the kinds in a params file
    """

    text: str
    entry: type[Row]
    reads: tuple[str, ...]
    lists: Callable[[Sources, Any, str], Lists]
    keys: tuple[str, ...] = ()
    order: int = 9

    def __post_init__(self) -> None:
        if IMAGES & {*self.reads} and not issubclass(self.entry, FoggyRow):
            raise ValueError(f"entry: {self.entry.__name__} has no beta, by which fog is read; derive it from FoggyRow")


def take(available: list[str], count: int, what: str) -> list[str]:
    """The first frames; FoggyError, naming the key that asks for them, if there are fewer."""
    if count > len(available):
        raise FoggyError(
            f"{what}: asks for {count} frames, but there are {len(available)}. "
            "Ask for fewer, or unpack the whole dataset."
        )
    return available[:count]
