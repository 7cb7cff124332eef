"""The state of a training as bytes: everything that the next step depends on, in safetensors, without pickle."""

import json
from dataclasses import dataclass, field

import torch
from torch import Tensor

from foggy_synscapes.networks.network import Network
from foggy_synscapes.networks.weights import assign_values, pack, read_tensors

KEY = "foggy_snapshot"


class SnapshotError(ValueError):
    """A snapshot is damaged, or is not one of this training; the message says which."""


@dataclass
class Progress:
    """What a training has done so far, apart from weights.

    step : steps done; curve : rows (see `loop.CURVE`); losses : sum and number of step losses since the last row
    best_loss, best_step : lowest validation loss so far and the step after which it was reached
    scaler : state of the loss scaling of float16, where there is one
    """

    step: int = 0
    curve: list[list[float | int | None]] = field(default_factory=list)
    losses: list[float] = field(default_factory=lambda: [0.0, 0])
    best_loss: float | None = None
    best_step: int | None = None
    scaler: dict[str, float] = field(default_factory=dict)


def dump(
    network: Network, optimiser: torch.optim.Optimizer, best: dict[str, Tensor], progress: Progress, settings: dict
) -> bytes:
    """A snapshot. `settings` : plain values that must be the same where it is taken up again.

    The schedule, the order of samples, the augmentation and dropout are functions of the seed and the step
    (see `streams`), so there is no other state to keep.
    """
    tensors = {f"network/{name}": tensor for name, tensor in network.state_dict().items()}
    tensors |= {f"best/{name}": tensor for name, tensor in best.items()}
    for name, parameter in network.named_parameters():
        buffer = optimiser.state.get(parameter, {}).get("momentum_buffer")
        if buffer is not None:
            tensors[f"momentum/{name}"] = buffer
    return pack(tensors, KEY, {"progress": vars(progress), "settings": settings})


def restore(
    data: bytes, network: Network, optimiser: torch.optim.Optimizer, settings: dict
) -> tuple[dict[str, Tensor], Progress]:
    """Bring a network and its optimiser to the state of a snapshot; returns the best weights so far and the progress.

    Raises SnapshotError if it is no snapshot, was cut off, was taken with other settings (which are named), or of
    another network.
    """
    parts: dict[str, dict[str, Tensor]] = {"network": {}, "best": {}, "momentum": {}}
    try:
        about, tensors = read_tensors(data, KEY)
        different = differences(about["settings"], json.loads(json.dumps(settings)))
        if different:
            raise ValueError("taken with other settings: " + "; ".join(different))
        for name, tensor in tensors.items():
            part, _, rest = name.partition("/")
            parts[part][rest] = tensor
        assign_values(network, parts["network"])
    except ValueError as error:
        raise SnapshotError(str(error)) from error
    for name, parameter in network.named_parameters():
        if name in parts["momentum"]:
            # The parameter's own layout in memory: the optimiser steps through both together.
            buffer = torch.empty_like(parameter).copy_(parts["momentum"][name])
            optimiser.state[parameter]["momentum_buffer"] = buffer
    return parts["best"], Progress(**about["progress"])


def differences(old: object, new: object, place: str = "") -> list[str]:
    """What differs between two trees of plain values, as lines "key: old -> new", sorted by key."""
    if isinstance(old, dict) and isinstance(new, dict):
        lines = []
        for key in sorted({*old, *new}):
            lines += differences(old.get(key), new.get(key), f"{place}.{key}" if place else key)
        return lines
    return [] if old == new else [f"{place}: {old} -> {new}"]
