"""Words that many sections use."""

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from foggy_synscapes.datasets import DATASETS, test_sets
from foggy_synscapes.fog.models import MODELS
from foggy_synscapes.registry import Registry
from foggy_synscapes.schema import Range

# Names become folders and words of a command line, so they are kept to what is harmless in both.
RowName = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9-]{0,63}$"), Range("letters, digits and -")]
SeedName = Annotated[str, Field(pattern=r"^[0-9]{1,9}$"), Range("up to 9 digits, quoted")]
NetworkName = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]{0,63}$"), Range("name of a network")]
Device = Literal["cpu", "cuda", "auto"]
Folder = Annotated[str, Field(min_length=1)]


def registered(name: str, registry: Registry, names: list[str] | None = None) -> str:
    """The name of an entry; ValueError that lists the known ones if there is none."""
    known = registry.names() if names is None else names
    if name not in known:
        raise ValueError(f"{name!r} is no {registry.what}; there are {', '.join(known)}")
    return name


def _test_set(name: str) -> str:
    if name in DATASETS and name not in test_sets():
        raise ValueError(f"{name!r} is no test set; there are {', '.join(test_sets())}")
    return registered(name, DATASETS, test_sets())


TestSet = Annotated[str, AfterValidator(_test_set), Range("name of a test set")]
FogModelName = Annotated[str, AfterValidator(lambda name: registered(name, MODELS)), Range("name of a fog model")]
