"""All sections of the params, and what they have to agree on."""

import itertools
from functools import cache
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from pydantic import Field, FiniteFloat, create_model, model_validator

from foggy_synscapes.datasets.dataset import STAND_IN
from foggy_synscapes.fog.optics import lighter_than_fog
from foggy_synscapes.params.complete import Complete
from foggy_synscapes.params.fog import Fog, Subset, subset_model
from foggy_synscapes.params.names import Device, Folder, RowName, TestSet
from foggy_synscapes.params.scenes import Filter, Scenes, scenes_model
from foggy_synscapes.params.stereo import StereoErrors
from foggy_synscapes.params.training import Train
from foggy_synscapes.registry import plugin_files
from foggy_synscapes.schema import Beta, Section, setting
from foggy_synscapes.subsets import KINDS
from foggy_synscapes.subsets.kind import IMAGES, ModelledRow
from foggy_synscapes.training.policy import Policy

Scale = Annotated[FiniteFloat, Field(ge=0.01, le=1)]
PAPERS_BETAS = '["0.005", "0.01", "0.02", "0.03", "0.06"]'


class Gpu(Section):
    """How a GPU computes; nothing of it matters on a CPU, where the same bytes come out each time."""

    tf32: bool = setting("TensorFloat-32 (10 bits of mantissa) in products of float32 numbers")
    deterministic: bool = setting(
        "only algorithms that give the same bytes each time; resizing is several times slower by them"
    )
    search: bool = setting("let cuDNN time its convolutions and take the fastest, which may differ from run to run")


class Evaluate(Section):
    """Which test sets are scored, and how."""

    threads: int = setting("CPU threads of a job", ge=1)
    device: Device | None = setting("where networks predict; null: where `device` says")
    workers: int = setting("threads that read and decode images ahead; 0: none", ge=0)
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


class View(Section):
    """What the pages of predictions show."""

    images: int = setting(
        "of each test set that are shown, at even distances; one of 1280 x 960 pixels takes about 0.4 MB of the page "
        "in 14 rows",
        unit="images",
        ge=1,
    )


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


class Atlas(Section):
    """How fog models are scored against path tracing."""

    tolerances: Annotated[list[float], Field(min_length=1)] = setting(
        "mean errors of a frame, for which the cheapest model that keeps to it is counted", unit="levels"
    )
    repeats: int = setting("times that each model is timed; the least counts", ge=1)


class Training(NamedTuple):
    """How long a network trains in a row. images_seen : drawn; the last step is always followed by a validation."""

    network: str
    row: str
    policy: Policy
    listed: int
    iterations: int
    images_seen: int
    validations: int


class Params(Section):
    """The whole experiment."""

    plugins: Folder | None = setting("folder of your own modules (networks, datasets, ...), from where a job runs")
    device: Device = setting("where networks compute; auto: on a GPU where there is one")
    gpu: Gpu
    scenes: Scenes
    filter: Filter
    complete: Complete | None = setting("fog on Cityscapes made here, from stereo; null: none is", default=None)
    stereo: StereoErrors | None = setting(
        "a simulated stereo camera, by whose depth Synscapes is fogged too; null: none", default=None
    )
    fog: Fog
    subset: Subset
    train: Train
    evaluate: Evaluate
    tables: Tables
    figures: Figures
    view: View
    stability: Stability
    atlas: Atlas
    tradeoff: Tradeoff

    @model_validator(mode="after")
    def _sections_agree(self) -> "Params":
        lists = self.subset.foggy().values()
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
        models = {entry.model for entry in self.subset.by_own_model().values() if isinstance(entry, ModelledRow)}
        if models != set(self.fog.also):
            raise ValueError(
                f"fog.also: has {', '.join(self.fog.also) or 'none'}, but the lists of subset.modelled ask for "
                f"{', '.join(sorted(models)) or 'none'}; they have to be the same"
            )
        made, asked_for = (
            set(self.complete.betas if self.complete else []),
            {entry.beta for entry in self.subset.made_here().values()},
        )
        if made != asked_for:
            raise ValueError(
                f"complete.betas: has {', '.join(sorted(made)) or 'none'}, but the lists of fog that is made, such as "
                f"subset.made, ask for {', '.join(sorted(asked_for)) or 'none'}; they have to be the same"
            )
        completed = self.subset.of_completed_depth()
        if bool(completed) != (self.stereo is not None):
            raise ValueError(
                f"stereo: {'missing' if completed else 'there'}, but subset.completed has "
                f"{', '.join(completed) or 'none'}; both go together"
            )
        if completed and self.fog.model != "homogeneous":
            raise ValueError(
                f"fog.model: {self.fog.model}, but fog of completed depth is homogeneous; so has to be the other"
            )
        for row, entry in completed.items():
            ends = self.fog.frames.first, self.fog.frames.last
            if entry.beta not in self.fog.betas or entry.train > ends[0] or entry.validation > ends[1]:
                raise ValueError(
                    f"subset.completed.{row}: fog.betas and fog.frames are those of the rows that it is compared with; "
                    "its beta has to be among them, and its frames not more"
                )
        names = [name for rows in self.subset.kinds().values() for name in rows]
        read = {name for kind, rows in self.subset.kinds().items() if rows for name in KINDS[kind].reads}
        read -= IMAGES
        read |= {"cityscapes_stereo"} if self.complete else set()
        absent = sorted({*read, *self.evaluate.test_sets, self.tradeoff.test_set} - set(self.scenes.roots))
        if absent:
            raise ValueError(f"scenes.roots: {', '.join(absent)} missing, which evaluate, tradeoff or subset needs")
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
        drawn = self.scenes.stand_in.frames("synscapes")
        asked = self.fog.frames.first + self.fog.frames.last
        if self.scenes.roots["synscapes"] == STAND_IN and asked > drawn:
            raise ValueError(f"scenes.stand_in.synscapes: {drawn} frames, fewer than fog.frames asks for")
        return self

    def fog_models(self) -> str:
        """What tables say of the fog models, where they are not all the paper's."""
        spelt = self.fog.spelt()
        found = [] if spelt == "homogeneous" else [f"Fog of Foggy Synscapes: {spelt}"]
        rows = self.subset.by_own_model().items()
        found += [f"{row}: {self.fog.spelt(entry.model)}" for row, entry in rows if isinstance(entry, ModelledRow)]
        return f"Fog models: {'; '.join(found)}." if found else ""

    def device_of(self, word: str) -> Device:
        """Where the networks of a command compute, such as train: where its section says, or else `device`."""
        return getattr(getattr(self, word, None), "device", None) or self.device

    def warnings(self) -> list[str]:
        """What is possible and yet departs from what the experiment is about."""
        return [f"fog.betas: {text}" for beta in self.fog.betas if (text := lighter_than_fog(float(beta)))]

    def trainings(self) -> list[Training]:
        """What is trained, once per seed: without rows whose model is a network's own weights as they are."""
        found = []
        for network, (row, entry) in itertools.product(self.train.networks, self.subset.rows().items()):
            policy, schedule = self.train.policy(network, row), self.train.schedule(network, row)
            if policy is not None and schedule is not None:
                listed, batch = entry.counts()[0], policy.batch
                steps, every = schedule.length.steps(listed, batch), schedule.validate_.steps(listed, batch)
                found.append(Training(network, row, policy, listed, steps, steps * batch, -(-steps // every)))
        return found

    @property
    def stand_in(self) -> bool:
        """Whether any dataset is drawn: then no score says anything about real fog, and tables and figures say so."""
        return STAND_IN in self.scenes.roots.values()


def model() -> type[Params]:
    """The schema with what registries declare: datasets, kinds of lists; those of plugins too."""
    return _model(tuple(plugin_files()))


@cache
def _model(_plugins: tuple[Path, ...]) -> type[Params]:
    declared: dict[str, Any] = {"scenes": (scenes_model(), ...), "subset": (subset_model(), ...)}
    return create_model("Params", __base__=Params, __doc__=Params.__doc__, **declared)
