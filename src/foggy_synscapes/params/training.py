"""The params section `train`, and what all sections are made of."""

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, model_validator

Network = Literal["refinenet", "bisenet"]
# Names become folders and words of a command line, so they are kept to what is harmless in both.
RowName = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9-]{0,63}$")]
SeedName = Annotated[str, Field(pattern=r"^[0-9]{1,9}$")]
Count = Annotated[int, Field(ge=1)]


class Section(BaseModel):
    """A part of the params file: unknown keys are errors, values do not change after reading."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Duration(Section):
    """A number of epochs or of iterations."""

    epochs: Count | None = None
    iterations: Count | None = None

    @model_validator(mode="after")
    def _one_of_both(self) -> "Duration":
        if (self.epochs is None) == (self.iterations is None):
            raise ValueError("give either epochs or iterations")
        return self

    def steps(self, images: int, batch: int) -> int:
        """Iterations for a list of so many images; an epoch's last batch is filled up, so no image is left out."""
        return self.iterations if self.iterations is not None else self.epochs * -(-images // batch)


class Policy(Section):
    """How a network is trained."""

    learning_rate: Annotated[FiniteFloat, Field(gt=0)]
    schedule: Literal["poly", "constant"]
    power: Annotated[FiniteFloat, Field(gt=0)]
    momentum: Annotated[FiniteFloat, Field(ge=0, lt=1)]
    weight_decay: Annotated[FiniteFloat, Field(ge=0)]
    norm_weight_decay: Annotated[FiniteFloat, Field(ge=0)]
    batch: Count
    accumulate: Count
    crop: tuple[Count, Count]
    scale: tuple[Annotated[FiniteFloat, Field(gt=0)], Annotated[FiniteFloat, Field(gt=0)]]
    flip: bool
    class_balance: bool
    loss: Literal["cross_entropy", "ohem"]
    ohem_threshold: Annotated[FiniteFloat, Field(gt=0, lt=1)]
    ohem_kept: Annotated[FiniteFloat, Field(ge=0, le=1)]
    auxiliary_weight: Annotated[FiniteFloat, Field(ge=0)]
    loss_stride: Literal[1, 2, 4, 8]
    backbone_rate: Annotated[FiniteFloat, Field(gt=0)]
    new_layer_rate: Annotated[FiniteFloat, Field(gt=0)]
    freeze_batch_norm: bool

    @model_validator(mode="after")
    def _consistent(self) -> "Policy":
        if self.batch % self.accumulate:
            raise ValueError(f"accumulate: {self.accumulate} passes do not divide a batch of {self.batch} images")
        if self.scale[0] > self.scale[1]:
            raise ValueError(f"scale: from {self.scale[0]} to {self.scale[1]}, expected the smaller factor first")
        return self


class BaselinePolicy(Policy):
    """How a network is trained from its own weights; names its length too."""

    length: Duration
    validate_: Annotated[Duration, Field(alias="validate")]


class Start(Section):
    """What a network starts from in one row, and how it is trained there: by its baseline's policy unless told."""

    weights: str
    policy: Policy | None = None


class Row(Section):
    """How long a row trains, how often it is validated and, where it starts from weights, from which."""

    length: Duration
    validate_: Annotated[Duration, Field(alias="validate")]
    start: dict[Network, Start] = {}


class NetworkSettings(Section):
    """Shape and policies of one network."""

    backbone: Literal["resnet18", "resnet34", "resnet50", "resnet101"]
    width: Annotated[int, Field(ge=8)]  # networks.config.NARROWEST, which not every command has to depend on
    decoder: Annotated[int, Field(ge=4)]
    weights: str
    baseline: BaselinePolicy | None
    fine_tuning: Policy

    @model_validator(mode="after")
    def _baseline_from_somewhere(self) -> "NetworkSettings":
        if self.baseline is None and self.weights == "none":
            raise ValueError("baseline: null takes the model in `weights` as row C, but weights is none")
        return self


class Train(Section):
    """The grid of trainings."""

    threads: Count
    workers: Annotated[int, Field(ge=0)]
    cache: Annotated[int, Field(ge=0)]
    device: Literal["cpu", "cuda"]
    precision: Literal["float32", "bfloat16", "measured"]
    memory_format: Literal["channels_last", "contiguous", "measured"]
    compile: bool
    curve: Count
    live: list[Literal["dvclive", "tensorboard"]]
    snapshot: Count
    seeds: Annotated[list[SeedName], Field(min_length=1)]
    networks: Annotated[list[Network], Field(min_length=1)]
    from_weights: list[RowName]
    from_baseline: list[RowName]
    rows: dict[RowName, Row | None]
    refinenet: NetworkSettings
    bisenet: NetworkSettings

    @model_validator(mode="after")
    def _rows_are_complete(self) -> "Train":
        trained = {*self.from_weights, *self.from_baseline}
        if set(self.rows) != trained:
            raise ValueError(
                f"rows: has {sorted(self.rows)}, but from_weights and from_baseline have {sorted(trained)}; a row in "
                "from_weights that is trained as long as the baseline of each network says is null"
            )
        for name, row in self.rows.items():
            if name in self.from_baseline and (row is None or row.start):
                raise ValueError(f"rows.{name}: starts from the baseline; give its length and validate, and no start")
            for network in self.networks if row is not None and name in self.from_weights else []:
                if self.policy(network, name) is None:
                    raise ValueError(
                        f"rows.{name}.start.{network}.policy: missing; train.{network}.baseline, which would stand for "
                        "it, is null"
                    )
        if self.from_baseline and "C" not in self.from_weights:
            raise ValueError("from_weights: row C is missing, from which the rows in from_baseline start")
        return self

    def policy(self, network: Network, row: RowName) -> Policy | None:
        """How a network is trained in a row; None where its weights are the row's model as they are."""
        settings: NetworkSettings = getattr(self, network)
        if row in self.from_baseline:
            return settings.fine_tuning
        start = self._start(network, row)
        return start.policy if start is not None and start.policy is not None else settings.baseline

    def weights(self, network: Network, row: RowName) -> str:
        """File that a row in `from_weights` starts from, or none."""
        start = self._start(network, row)
        return start.weights if start is not None else getattr(self, network).weights

    def _start(self, network: Network, row: RowName) -> Start | None:
        entry = self.rows[row]
        return entry.start.get(network) if entry is not None else None
