"""The experiment's parameters: read from YAML, checked, typed and frozen.

A params file is complete: no value hides in the code. Units and sources stand beside the values, in
`params.yaml`; here stands what is possible at all.
"""

import difflib
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, FiniteFloat, ValidationError, model_validator

from foggy_synscapes.datasets.synscapes import SCENE_KEYS
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.plain_yaml import read_yaml
from foggy_synscapes.params.training import Count, RowName, Section, Train

STAND_IN = "stand-in"

TestSet = Literal["foggy_driving", "foggy_zurich", "cityscapes"]


def beta_name(text: str) -> str:
    """Spell an attenuation coefficient in 1/m the way folders spell it: shortest decimal, no exponent.

    >>> beta_name("0.010")
    '0.01'

    Raises ValueError unless it is a finite number above 0.
    """
    try:
        value = float(text)
    except ValueError:
        raise ValueError(
            f"beta {text!r} is not a number; it is the attenuation coefficient in 1/m, e.g. 0.005"
        ) from None
    if not 0 < value < float("inf"):
        raise ValueError(f"beta {text} is not a positive finite number in 1/m, e.g. 0.005")
    from decimal import Decimal

    return f"{Decimal(repr(value)):f}"


def _canonical_beta(text: str) -> str:
    name = beta_name(text)
    if name != text:
        raise ValueError(f"beta {text!r}: write {name!r}, as the folder spells it, so that no two betas share a folder")
    return text


Beta = Annotated[str, AfterValidator(_canonical_beta)]


Folder = Annotated[str, Field(min_length=1)]


class Roots(Section):
    """Folder of each dataset, or "stand-in"."""

    synscapes: Folder
    cityscapes: Folder
    foggy_cityscapes: Folder
    foggy_driving: Folder
    foggy_zurich: Folder


class CityscapesCounts(Section):
    """Frames rendered for a layout with training and validation splits."""

    train: Count
    val: Count


class DrivingCounts(Section):
    """Frames rendered with fine and with coarse labels."""

    fine: Count
    coarse: Count


class StandIn(Section):
    """How much stand-in data is rendered, and from which seed."""

    seed: Annotated[int, Field(ge=0)]
    size: tuple[Annotated[int, Field(ge=32, le=4096)], Annotated[int, Field(ge=32, le=8192)]]
    synscapes: Count
    cityscapes: CityscapesCounts
    foggy_cityscapes: CityscapesCounts
    foggy_driving: DrivingCounts
    foggy_zurich: Count

    @model_validator(mode="after")
    def _refined_are_cityscapes(self) -> "StandIn":
        for split in ("train", "val"):
            refined, whole = getattr(self.foggy_cityscapes, split), getattr(self.cityscapes, split)
            if refined > whole:
                raise ValueError(
                    f"foggy_cityscapes.{split}: {refined} refined frames of only {whole} Cityscapes frames"
                )
        return self


class Scenes(Section):
    """Where the raw data is, and how Synscapes is cut into shards."""

    roots: Roots
    refined_list: Annotated[str, Field(pattern=r"^[A-Za-z0-9_-][A-Za-z0-9._-]*(/[A-Za-z0-9_-][A-Za-z0-9._-]*)*\.txt$")]
    zurich_list: Literal["testv1", "testv2"]
    shard_frames: Count
    shards: Annotated[list[str], Field(min_length=1)]
    stand_in: StandIn

    @model_validator(mode="after")
    def _shards_are_numbered(self) -> "Scenes":
        expected = [f"{number:04d}" for number in range(len(self.shards))]
        if self.shards != expected:
            raise ValueError(f"shards: expected the names {expected[0]} to {expected[-1]} in order, got {self.shards}")
        if self.roots.synscapes == STAND_IN:
            needed = -(-self.stand_in.synscapes // self.shard_frames)
            if needed != len(self.shards):
                raise ValueError(
                    f"shards: {self.stand_in.synscapes} frames in shards of {self.shard_frames} are {needed} shards, "
                    f"got {len(self.shards)}"
                )
        return self

    def deciding(self, dataset: str) -> list[str]:
        """Dotted keys of what decides which files a dataset has and what is drawn."""
        keys = ["roots." + dataset]
        keys += {
            "synscapes": ["shard_frames", "shards"],
            "foggy_cityscapes": ["refined_list"],
            "foggy_zurich": ["zurich_list"],
        }.get(dataset, [])
        if getattr(self.roots, dataset) == STAND_IN:
            counts = [dataset] + (["cityscapes"] if dataset == "foggy_cityscapes" else [])
            keys += [f"stand_in.{key}" for key in ("seed", "size", *counts)]
        return [f"scenes.{key}" for key in keys]


class FilterRule(Section):
    """Keep a frame if the scene key lies between minimum and maximum, both included."""

    key: str
    minimum: FiniteFloat | None = None
    maximum: FiniteFloat | None = None

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

    rules: list[FilterRule]


class Ends(Section):
    """The first and the last so many kept frames."""

    first: Count
    last: Annotated[int, Field(ge=0)]


class Fog(Section):
    """How Foggy Synscapes is rendered."""

    betas: Annotated[list[Beta], Field(min_length=1)]
    geometry: Literal["paper", "exact"]
    frames: Ends
    blue_airlight: Literal["keep", "drop", "grey"]
    png_level: Annotated[int, Field(ge=0, le=3)]
    render: Literal["ahead", "on_the_fly"]

    @model_validator(mode="after")
    def _distinct(self) -> "Fog":
        if len(set(self.betas)) != len(self.betas):
            raise ValueError(f"betas: each once, got {self.betas}")
        return self


class ClearList(Section):
    """A list of Cityscapes images."""

    train: Count
    validation: Count


class FoggyList(ClearList):
    """A list of images of one foggy dataset."""

    beta: Beta


class MixedList(FoggyList):
    """A list that mixes Foggy Synscapes with Foggy Cityscapes; counts are those of Foggy Synscapes."""

    beta_foggy_cityscapes: Beta
    ratio: tuple[Count, Count]


class Subset(Section):
    """The training and validation lists, by kind."""

    clear: dict[RowName, ClearList]
    partial: dict[RowName, FoggyList]
    pure: dict[RowName, FoggyList]
    mixed: dict[RowName, MixedList]

    def rows(self) -> dict[str, ClearList]:
        """All lists by row name."""
        return {**self.clear, **self.partial, **self.pure, **self.mixed}

    def kind(self, row: str) -> str:
        """The kind (clear, partial, pure, mixed) of a row."""
        return next(kind for kind in ("clear", "partial", "pure", "mixed") if row in getattr(self, kind))


class Evaluate(Section):
    """Which test sets are scored."""

    threads: Count
    test_sets: Annotated[list[TestSet], Field(min_length=1)]


class TableRow(Section):
    """A printed row: its training row, its labels, and the published number of images (here it is the list's)."""

    row: RowName
    training: str
    fine_tuning: str
    images: int | None = None


class Tables(Section):
    """What the tables print."""

    rows: Annotated[list[TableRow], Field(min_length=1)]


class Figures(Section):
    """What the figures show."""

    betas: list[Beta]
    comparison_beta: Beta
    images: Count


class Stability(Section):
    """How numbers are checked at their extremes."""

    digits: Annotated[int, Field(ge=20, le=200)]


Scale = Annotated[FiniteFloat, Field(ge=0.01, le=1)]


class Tradeoff(Section):
    """How time is weighed against accuracy."""

    betas: Annotated[list[Beta], Field(min_length=1)]
    frames: Count
    repeats: Count
    row: RowName
    test_set: TestSet
    scales: Annotated[list[Scale], Field(min_length=1)]
    calibration: Count
    steps: Count

    @model_validator(mode="after")
    def _from_full_scale(self) -> "Tradeoff":
        if self.scales[0] != 1 or len(set(self.scales)) != len(self.scales):
            raise ValueError(f"scales: 1.0 first, with which the others are compared, and each once; got {self.scales}")
        return self


class Params(Section):
    """The whole experiment."""

    scenes: Scenes
    filter: Filter
    fog: Fog
    subset: Subset
    train: Train
    evaluate: Evaluate
    tables: Tables
    figures: Figures
    stability: Stability
    tradeoff: Tradeoff

    @model_validator(mode="after")
    def _sections_agree(self) -> "Params":
        lists = list(self.subset.pure.values()) + list(self.subset.mixed.values())
        if lists:
            betas = {entry.beta for entry in lists}
            unused, missing = sorted(set(self.fog.betas) - betas), sorted(betas - set(self.fog.betas))
            if unused:
                raise ValueError(
                    f"fog.betas: no list in subset uses {', '.join(unused)}; add a row there, or remove it"
                )
            if missing:
                raise ValueError(
                    f"fog.betas: a list in subset asks for {', '.join(missing)}, which is not there; add it"
                )
            ends = max(entry.train for entry in lists), max(entry.validation for entry in lists)
            if ends != (self.fog.frames.first, self.fog.frames.last):
                raise ValueError(
                    f"fog.frames: the lists in subset ask for the first {ends[0]} and the last {ends[1]} kept frames, "
                    f"got first {self.fog.frames.first} and last {self.fog.frames.last}"
                )
        names = [name for kind in ("clear", "partial", "pure", "mixed") for name in getattr(self.subset, kind)]
        trained = [*self.train.from_weights, *self.train.from_baseline]
        for key, each in (
            ("subset", names),
            ("train.from_weights and from_baseline", trained),
            ("train.seeds", [int(seed) for seed in self.train.seeds]),
            ("train.networks", self.train.networks),
            ("evaluate.test_sets", self.evaluate.test_sets),
            ("tables.rows", [entry.row for entry in self.tables.rows]),
        ):
            if len(set(each)) != len(each):
                raise ValueError(f"{key}: each once, got {each}")
        rows = set(trained)
        if rows != set(self.subset.rows()):
            raise ValueError(f"train: trains rows {sorted(rows)}, but subset lists {sorted(self.subset.rows())}")
        if self.tradeoff.row not in rows:
            raise ValueError(f"tradeoff.row: {self.tradeoff.row} is no row of train, which has {sorted(rows)}")
        counts = self.scenes.stand_in
        if self.scenes.roots.synscapes == STAND_IN and self.fog.frames.first + self.fog.frames.last > counts.synscapes:
            raise ValueError(f"scenes.stand_in.synscapes: {counts.synscapes} frames, fewer than fog.frames asks for")
        return self

    @property
    def stand_in(self) -> bool:
        """Whether any dataset is drawn: then no score says anything about real fog, and tables and figures say so."""
        return STAND_IN in self.scenes.roots.model_dump().values()


def load(path: str | Path) -> Params:
    """Read and check a params file.

    Raises
    ------
    FoggyError
        Naming the file and the key that is missing, misspelt, twice, of a wrong type, impossible or contradicted.
    """
    document = read_yaml(path)
    if not isinstance(document, dict):
        raise FoggyError(f"{path}: expected sections such as scenes, fog and train; got {type(document).__name__}")
    return check(document, str(path))


def check(document: dict[str, Any], name: str) -> Params:
    """Check a params document that is read already; `name` stands for it in messages."""
    try:
        return Params.model_validate(document)
    except ValidationError as error:
        lines = [f"{name}: {_explain(problem)}" for problem in error.errors()]
        raise FoggyError("\n".join(lines)) from None


def root(params: Params, dataset: str) -> Path:
    """Folder in which a dataset's real layout begins."""
    folder = getattr(params.scenes.roots, dataset)
    return Path("results/scenes") / dataset if folder == STAND_IN else Path(folder)


def _explain(problem: dict[str, Any]) -> str:
    place = ".".join(str(part) for part in problem["loc"]) or "the whole file"
    kind, message = problem["type"], problem["msg"].removeprefix("Value error, ")
    if kind == "extra_forbidden":
        return f"{place}: unknown key{_suggest(problem['loc'])} Remove it or correct its spelling."
    if kind == "missing":
        return f"{place}: missing. Every value is stated; compare params.yaml."
    if kind == "value_error":
        return f"{place}: {message}"
    return f"{place}: {message}; got {problem['input']!r}"


def _suggest(place: tuple) -> str:
    names = {field.alias or name for model in Section.__subclasses__() for name, field in model.model_fields.items()}
    close = difflib.get_close_matches(str(place[-1]), sorted(names), n=1)
    return f"; did you mean {close[0]}?" if close else "."
