"""The params sections of what is made of trained networks: scores, tables, figures and measurements."""

from typing import Annotated

from pydantic import Field, FiniteFloat, model_validator

from foggy_synscapes.params.names import RowName, TestSet
from foggy_synscapes.schema import Beta, Section, setting

Scale = Annotated[FiniteFloat, Field(ge=0.01, le=1)]
PAPERS_BETAS = '["0.005", "0.01", "0.02", "0.03", "0.06"]'


class Evaluate(Section):
    """Which test sets are scored."""

    threads: int = setting("CPU threads of a job", ge=1)
    test_sets: list[TestSet] = setting("cityscapes: the clear validation frames", min_length=1)


class TableRow(Section):
    """A printed row: its training row, its labels, and the published number of images (here it is the list's)."""

    inline = True

    row: RowName = setting("row of subset and train")
    training: str = setting("printed: what the network was trained on")
    fine_tuning: str = setting("printed: what it was fine-tuned on")
    images: int | None = setting("printed beside ours: the published count", default=None, unit="images")


class Tables(Section):
    """What the tables print."""

    rows: list[TableRow] = setting(
        'printed, in this order; "images" is the published count, what is asked for here is in subset', min_length=1
    )


class Figures(Section):
    """What the figures show."""

    betas: list[Beta] = setting("of the beta strip", unit="1/m", published=PAPERS_BETAS, source="section III")
    comparison_beta: Beta = setting(
        "of Foggy Cityscapes against Foggy Synscapes", unit="1/m", published='"0.02"', source="figure 4"
    )
    images: int = setting("of each test set that are shown", unit="images", ge=1)


class Stability(Section):
    """How numbers are checked at their extremes."""

    digits: int = setting("decimal digits of the reference arithmetic (mpmath)", ge=20, le=200)
    searched: int = setting(
        "looked through for fog next to a rounding step, for each camera, geometry and beta", unit="pixels", ge=64
    )


class Tradeoff(Section):
    """How time is weighed against accuracy."""

    betas: Annotated[list[Beta], Field(min_length=1)] = setting(
        "at which fog is measured", unit="1/m", published=PAPERS_BETAS, source="section III"
    )
    frames: int = setting("kept ones that are measured", unit="frames", ge=1)
    repeats: int = setting("times that each variant is timed on each frame; the median counts", ge=1)
    row: RowName = setting("row of the tables whose models (of the first seed) are measured")
    test_set: TestSet = setting("on which they are scored")
    scales: Annotated[list[Scale], Field(min_length=1)] = setting(
        "of the image's sides, at which the networks work; 1.0 first"
    )
    calibration: int = setting("of training, whose ranges the 8-bit networks take", unit="images", ge=1)
    steps: int = setting("of training that are measured", unit="iterations", ge=1)
    images: int = setting(
        "at most, on which networks and fog are scored: of the test set, and the last kept frames", unit="images", ge=1
    )
    minutes: float = setting("after which no further image is begun, for each part", unit="minutes", gt=0)
    tolerance: float = setting(
        "of mean IoU that a recommended way may lose, by its 95 % interval", unit="points", gt=0, le=100
    )

    @model_validator(mode="after")
    def _from_full_scale(self) -> "Tradeoff":
        if self.scales[0] != 1 or len(set(self.scales)) != len(self.scales):
            raise ValueError(f"scales: 1.0 first, with which the others are compared, and each once; got {self.scales}")
        return self
