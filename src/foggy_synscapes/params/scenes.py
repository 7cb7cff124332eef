"""The params sections `scenes` and `filter`: where the raw data is, and which frames are kept."""

import difflib
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, FiniteFloat, create_model, model_validator

from foggy_synscapes.datasets import DATASETS
from foggy_synscapes.datasets.dataset import STAND_IN
from foggy_synscapes.datasets.synscapes import SCENE_KEYS
from foggy_synscapes.params.names import Folder, registered
from foggy_synscapes.schema import Range, Section, setting
from foggy_synscapes.standin.layouts import STAND_INS

LIST_PATTERN = r"^[A-Za-z0-9_-][A-Za-z0-9._-]*(/[A-Za-z0-9_-][A-Za-z0-9._-]*)*\.txt$"


def _known_roots(roots: dict[str, str]) -> dict[str, str]:
    for name, folder in roots.items():
        registered(name, DATASETS)
        if folder == STAND_IN and name not in STAND_INS:
            raise ValueError(f"{name}: has no stand-in; name the folder of the dataset")
    return roots


Roots = Annotated[dict[str, Folder], AfterValidator(_known_roots)]


class StandIn(Section):
    """How much stand-in data is rendered, and from which seed; beside these, the frames of each dataset."""

    seed: int = setting("of all random choices; the test sets draw from streams of their own", ge=0)
    size: tuple[Annotated[int, Field(ge=32, le=4096)], Annotated[int, Field(ge=32, le=8192)]] = setting(
        "rows and columns", unit="pixels", published="[720, 1440], as Synscapes"
    )

    def frames(self, dataset: str) -> int:
        """How many frames of a dataset are drawn, where that is one number."""
        return getattr(self, dataset)


class Scenes(Section):
    """Where the raw data is, and how Synscapes is cut into shards."""

    roots: Roots = setting(
        'folder of each dataset, or "stand-in": rendered under results/scenes/', key="DATASET", merged=True
    )
    refined_list: Annotated[str, Field(pattern=LIST_PATTERN), Range("path of a .txt file")] = setting(
        "in the Foggy Cityscapes root: its 498 + 52 refined images"
    )
    stereo_list: Literal["all"] | Annotated[str, Field(pattern=LIST_PATTERN), Range("path of a .txt file")] = setting(
        "in the cityscapes_stereo root: frames on which fog is made here; all: those with a right view"
    )
    zurich_list: Literal["testv1", "testv2"] = setting(
        "testv2: 40 images; testv1: 16", published="testv2", source="section IV"
    )
    shard_frames: int = setting("of Synscapes in a shard; 500 at full scale", unit="frames", ge=1)
    shards: list[str] = setting(
        "of Synscapes, numbered from 0000: ids 1 to shard_frames, then the next so many, to its last frame",
        min_length=1,
    )
    stand_in: StandIn = setting("what is rendered where a root is stand-in, and only there")

    @model_validator(mode="after")
    def _drawn_as_asked(self) -> "Scenes":
        for name in [name for name, folder in self.roots.items() if folder == STAND_IN]:
            for other in (name, *STAND_INS[name].others):
                if getattr(self.stand_in, other) is None:
                    raise ValueError(f"stand_in.{other}: missing. Say how many frames of {name} are rendered.")
            STAND_INS[name].check(self.stand_in)
        return self

    @model_validator(mode="after")
    def _shards_are_numbered(self) -> "Scenes":
        expected = [f"{number:04d}" for number in range(len(self.shards))]
        if self.shards != expected:
            raise ValueError(f"shards: expected the names {expected[0]} to {expected[-1]} in order, got {self.shards}")
        if self.roots["synscapes"] == STAND_IN:
            drawn = self.stand_in.frames("synscapes")
            needed = -(-drawn // self.shard_frames)
            if needed != len(self.shards):
                raise ValueError(
                    f"shards: {drawn} frames in shards of {self.shard_frames} are {needed} shards, "
                    f"got {len(self.shards)}"
                )
        return self


def _about(entry: Any) -> Any:
    return setting(entry.text, unit="frames", published=entry.published, default=None)


def scenes_model() -> type[Scenes]:
    """The section, with an entry of `stand_in` for each dataset that has a stand-in."""
    counts: dict[str, Any] = {name: (STAND_INS[name].counts | None, _about(STAND_INS[name])) for name in STAND_INS}
    stand_in = create_model("StandIn", __base__=StandIn, __doc__=StandIn.__doc__, **counts)
    about = Scenes.model_fields["stand_in"].description or ""
    return create_model("Scenes", __base__=Scenes, __doc__=Scenes.__doc__, stand_in=(stand_in, setting(about)))


class FilterRule(Section):
    """Keep a frame if the scene key lies between minimum and maximum, both included."""

    inline = True

    key: str = setting("scene key of Synscapes: a column of results/filter/frames.csv")
    minimum: FiniteFloat | None = setting("kept from here, in the key's unit", default=None)
    maximum: FiniteFloat | None = setting("kept up to here, in the key's unit", default=None)

    @model_validator(mode="after")
    def _bounded(self) -> "FilterRule":
        if self.key not in SCENE_KEYS:
            close = difflib.get_close_matches(self.key, SCENE_KEYS, n=1)
            hint = f"; did you mean {close[0]}?" if close else ", which are the columns of results/filter/frames.csv"
            raise ValueError(f"{self.key!r} is no scene key of Synscapes{hint}")
        if self.minimum is None and self.maximum is None:
            raise ValueError(f"rule on {self.key}: give minimum, maximum or both")
        if self.minimum is not None and self.maximum is not None and self.minimum > self.maximum:
            raise ValueError(f"rule on {self.key}: minimum {self.minimum} is above maximum {self.maximum}")
        return self


class Filter(Section):
    """Which frames the metadata keeps."""

    rules: list[FilterRule] = setting(
        "a frame is kept if every rule holds; sky_contrast has no unit, 5 to 6 is direct sun",
        published="[], every frame",
        source="section IV.B suggests {key: sky_contrast, maximum: 5.0}; it was not used there",
    )
