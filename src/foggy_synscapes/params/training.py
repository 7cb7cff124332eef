"""The params section `train`."""

from typing import Literal

from pydantic import ConfigDict, Field, model_validator

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.networks import NETWORKS
from foggy_synscapes.params.names import Device, NetworkName, RowName, SeedName
from foggy_synscapes.schema import Section, setting
from foggy_synscapes.training.policy import BASELINE, Duration, Policy


class BaselinePolicy(Policy):
    """How a network is trained from its own weights; names its length too."""

    length: Duration = setting("how long it trains")
    validate_: Duration = setting("how often it is validated", alias="validate")


class Start(Section):
    """What a network starts from in one row, and how it is trained there: by its baseline's policy unless told."""

    weights: str = setting("none (random start) or a file made by `foggy weights import`")
    policy: Policy | None = setting("with the keys of fine_tuning; null: that of the network's baseline", default=None)


class Row(Section):
    """How long a row trains, how often it is validated and, where it starts from weights, from which."""

    inline = True

    length: Duration = setting("how long it trains")
    validate_: Duration = setting("how often it is validated", alias="validate")
    start: dict[NetworkName, Start] = setting(
        "of a row in from_weights: what a network starts from there, instead of its own weights",
        default={},
        key="NETWORK",
    )


class NetworkSettings(Section):
    """Shape and policies of one network."""

    backbone: Literal["resnet18", "resnet34", "resnet50", "resnet101"] = setting("ResNet (He et al. 2016)")
    width: int = setting("of the first stage", unit="channels", ge=8)  # networks.config.NARROWEST
    decoder: int = setting(
        "RefineNet: of the three upper decoder levels, the deepest has twice as many; BiSeNet: of attention refinement",
        unit="channels",
        ge=4,
    )
    weights: str = setting("none (random start) or a file made by `foggy weights import`")
    baseline: BaselinePolicy | None = setting("row C; null takes the model in weights itself for it")
    fine_tuning: Policy = setting("rows that start from the baseline")

    @model_validator(mode="after")
    def _baseline_from_somewhere(self) -> "NetworkSettings":
        if self.baseline is None and self.weights == "none":
            raise ValueError("baseline: null takes the model in `weights` as row C, but weights is none")
        return self


class Train(Section):
    """The grid of trainings. Each further key is the name of a network and holds its settings."""

    model_config = ConfigDict(extra="allow", frozen=True)
    __pydantic_extra__: dict[str, NetworkSettings] = Field(init=False)

    threads: int = setting("CPU threads of a job: part of what makes its bytes, so not the engine's --cores", ge=1)
    workers: int = setting("loader processes; 0 loads in the training process", ge=0)
    cache: int = setting(
        "of decoded images and labels kept in memory; larger lists are read again each time", unit="MiB", ge=0
    )
    device: Device | None = setting("where networks are trained; null: where `device` says")
    precision: Literal["float32", "bfloat16", "float16"] = setting(
        "of the networks' arithmetic; weights stay float32, and in float16 the loss is scaled"
    )
    memory_format: Literal["channels_last", "contiguous"] = setting(
        "of images in memory; with channels_last BiSeNet was 10 to 20 %, RefineNet 30 % faster on a CPU"
    )
    compile: bool = setting("torch.compile: a first step of up to minutes, then faster ones")
    curve: int = setting("between rows of curves.csv", unit="iterations", ge=1)
    live: list[Literal["dvclive", "tensorboard"]] = setting(
        "where else curves are shown while training (docs/experiment.md)"
    )
    snapshot: int = setting("between snapshots, from which an interrupted training resumes", unit="iterations", ge=1)
    seeds: list[SeedName] = setting("one whole grid per seed, quoted", min_length=1)
    networks: list[NetworkName] = setting("trained; each has its settings in a section of its name", min_length=1)
    from_weights: list[RowName] = setting("rows that start from a network's own weights")
    from_baseline: list[RowName] = setting("rows that start from the selected snapshot of C")
    rows: dict[RowName, Row | None] = setting(
        "how long a row trains and how often it is validated; null: as the baseline of each network says", key="ROW"
    )

    @model_validator(mode="after")
    def _networks_are_there(self) -> "Train":
        asked = [("networks", name) for name in self.networks]
        asked += [(f"rows.{row}.start", name) for row, entry in self.rows.items() if entry for name in entry.start]
        for place, name in asked:
            if name not in NETWORKS.names():
                raise ValueError(f"{place}: {name} is no network; there are {', '.join(NETWORKS.names())}")
        missing = [name for name in self.networks if name not in self.settings]
        if missing:
            raise ValueError(f"networks: {missing[0]} has no settings; state them as train.{missing[0]}")
        return self

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
        if self.from_baseline and BASELINE not in self.from_weights:
            raise ValueError(f"from_weights: row {BASELINE} is missing, from which the rows in from_baseline start")
        return self

    @property
    def settings(self) -> dict[str, NetworkSettings]:
        """Settings by network, also of networks that are not trained."""
        return self.__pydantic_extra__

    def network(self, name: str) -> NetworkSettings:
        """Settings of a network; raises FoggyError if there are none."""
        if name not in self.settings:
            raise FoggyError(f"{name}: has no settings in the params section train; {', '.join(self.settings)} have")
        return self.settings[name]

    def policy(self, network: str, row: str) -> Policy | None:
        """How a network is trained in a row; None where its weights are the row's model as they are."""
        if row in self.from_baseline:
            return self.network(network).fine_tuning
        start = self._start(network, row)
        return start.policy if start is not None and start.policy is not None else self.network(network).baseline

    def schedule(self, network: str, row: str) -> Row | BaselinePolicy | None:
        """How long a network trains in a row and how often it is validated; None where it does not train."""
        return self.rows[row] or self.network(network).baseline

    def weights(self, network: str, row: str) -> str:
        """File that a row in `from_weights` starts from, or none."""
        start = self._start(network, row)
        return start.weights if start is not None else self.network(network).weights

    def _start(self, network: str, row: str) -> Start | None:
        entry = self.rows[row]
        return entry.start.get(network) if entry is not None else None
