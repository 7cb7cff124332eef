"""The params sections `fog` and `subset`: what is rendered, and the lists that ask for it."""

from collections.abc import Mapping
from types import GenericAlias
from typing import Annotated, Any, Literal

from pydantic import Field, create_model, model_validator

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.fog.models import spelling
from foggy_synscapes.params.names import FogModelName, RowName
from foggy_synscapes.schema import Beta, Section, setting
from foggy_synscapes.subsets import KINDS
from foggy_synscapes.subsets.kind import COMPLETED, FOG, MADE, MODELLED, FoggyRow, Row


class Ends(Section):
    """The first and the last so many kept frames."""

    inline = True

    first: int = setting("for training", unit="frames", ge=1)
    last: int = setting("for validation", unit="frames", ge=0)


class Fog(Section):
    """How Foggy Synscapes is rendered."""

    betas: Annotated[list[Beta], Field(min_length=1)] = setting(
        "attenuation coefficients, quoted; meteorological optical range = 2.996 / beta, 599 m at 0.005",
        unit="1/m",
        published="0.005",
        source="section III",
    )
    model: FogModelName = setting(
        "homogeneous: uniform airlight in homogeneous air; others may be added",
        published="homogeneous",
        source="eq. (1)",
    )
    also: list[FogModelName] = setting(
        "further models, by which fog is rendered too, for rows of the kind modelled", default=[]
    )
    values: dict[FogModelName, dict[str, Any]] = setting(
        "of models, where not their defaults: {scale_height: 10}; with units, ranges and sources in docs/fog_models.md",
        key="MODEL",
        default={},
    )
    geometry: Literal["paper", "exact"] = setting(
        "paper: as the published code (1-based pixels, fx on both axes); exact: fx and fy, pixel centres"
    )
    frames: Ends = setting(
        "kept ones that the subsets ask for: the first (training) and the last (validation)",
        unit="frames",
        published="24,500 and 500",
    )
    blue_airlight: Literal["keep", "drop", "grey"] = setting(
        "what to do where the airlight is blue", source="section III, failure case"
    )
    png_level: int = setting(
        "of the foggy images; 0: codes for photographs, fastest; 1 to 3: effort of deflate", ge=0, le=3
    )
    render: Literal["ahead", "on_the_fly"] = setting(
        "ahead: foggy images in shards; on_the_fly: recipes there, composited when training reads them"
    )

    @model_validator(mode="after")
    def _distinct(self) -> "Fog":
        if len(set(self.betas)) != len(self.betas):
            raise ValueError(f"betas: each once, got {self.betas}")
        if len({self.model, *self.also}) != 1 + len(self.also):
            raise ValueError(f"also: models beside {self.model}, each once, got {self.also}")
        for name in self.values:
            if name not in (self.model, *self.also):
                raise ValueError(f"values: {name} is neither fog.model nor in fog.also; add it there, or remove it")
        for name in (self.model, *self.also):
            try:
                self.spelt(name)
            except FoggyError as error:
                raise ValueError(str(error)) from error
        return self

    def spelt(self, model: str = "") -> str:
        """A model (that of `model`, unless named) with its values, as records, recipes and captions spell it."""
        values: Mapping[str, Any] = self.values.get(model or self.model, {})
        return spelling(model or self.model, values)


class Subset(Section):
    """The training and validation lists: by kind, then by row of the tables."""

    def kinds(self) -> dict[str, dict[str, Row]]:
        """All lists by kind and row name."""
        return {kind: getattr(self, kind) for kind in type(self).model_fields}

    def rows(self) -> dict[str, Row]:
        """All lists by row name."""
        return {row: entry for rows in self.kinds().values() for row, entry in rows.items()}

    def kind(self, row: str) -> str:
        """The kind of a row, such as pure."""
        return next(kind for kind, rows in self.kinds().items() if row in rows)

    def foggy(self) -> dict[str, FoggyRow]:
        """The lists of Foggy Synscapes images, by whatever model, by row name."""
        return {**self._reading(FOG), **self.by_own_model()}

    def by_own_model(self) -> dict[str, FoggyRow]:
        """Those of them by a model that the row names."""
        return self._reading(MODELLED)

    def made_here(self) -> dict[str, FoggyRow]:
        """The lists of fog on Cityscapes that is made here, by row name."""
        return self._reading(MADE)

    def of_completed_depth(self) -> dict[str, FoggyRow]:
        """The lists of Foggy Synscapes of completed depth by row name."""
        return self._reading(COMPLETED)

    def _reading(self, images: str) -> dict[str, FoggyRow]:
        kinds = [rows for kind, rows in self.kinds().items() if images in KINDS[kind].reads]
        return {row: entry for rows in kinds for row, entry in rows.items() if isinstance(entry, FoggyRow)}


def subset_model() -> type[Subset]:
    """The section, with a key for each kind of list."""
    names = sorted(KINDS, key=lambda name: (KINDS[name].order, name))
    kinds: dict[str, Any] = {
        name: (GenericAlias(dict, (RowName, KINDS[name].entry)), setting(KINDS[name].text, key="ROW", default={}))
        for name in names
    }
    return create_model("Subset", __base__=Subset, __doc__=Subset.__doc__, **kinds)
