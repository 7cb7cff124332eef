"""The params sections `fog` and `subset`: what is rendered, and the lists that ask for it."""

from types import GenericAlias
from typing import Annotated, Any, Literal

from pydantic import Field, create_model, model_validator

from foggy_synscapes.params.names import FogModelName, RowName
from foggy_synscapes.schema import Beta, Section, setting
from foggy_synscapes.subsets import KINDS
from foggy_synscapes.subsets.kind import COMPLETED, FOG, MADE, FoggyRow, Row


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
        return self


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
        """The lists of Foggy Synscapes images by row name."""
        return self._reading(FOG)

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
