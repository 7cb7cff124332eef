"""What a kind of list declares: its entries in the params, what it reads, and how its lists are made."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.schema import Beta, Section, setting
from foggy_synscapes.subsets.sources import Sources

Line = tuple[str, str, str, str]
"""URI of an image, its SHA-256, URI of its label map, its SHA-256."""
Lists = tuple[list[Line], list[Line]]
"""The training and the validation list."""
FOG = "fog"
"""In `Kind.reads`: the kept frames and the shards of Foggy Synscapes at the entry's beta."""


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


@dataclass(frozen=True)
class Kind:
    """A kind of list.

    text : what its lists are, in a few words
    entry : model of an entry in the params section `subset`; a FoggyRow where FOG is read
    reads : datasets whose indexes it reads, and FOG
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
        if FOG in self.reads and not issubclass(self.entry, FoggyRow):
            raise ValueError(f"entry: {self.entry.__name__} has no beta, by which fog is read; derive it from FoggyRow")


def take(available: list[str], count: int, what: str) -> list[str]:
    """The first frames; FoggyError, naming the key that asks for them, if there are fewer."""
    if count > len(available):
        raise FoggyError(f"{what}: asks for {count} frames, but there are {len(available)}. Ask for fewer.")
    return available[:count]
