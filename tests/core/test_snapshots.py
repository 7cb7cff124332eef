"""Snapshots fit only the training that they were taken of."""

import pytest
import torch

from foggy_synscapes.networks import NetworkConfig
from foggy_synscapes.networks.network import build
from foggy_synscapes.training import snapshots
from foggy_synscapes.training.snapshots import Progress, differences

TINY = NetworkConfig("bisenet", "resnet18", width=8, decoder=4)
SETTINGS = {"params": {"learning_rate": 0.01, "crop": (96, 128)}, "inputs": {"train.csv": "ab"}}


def state(config=TINY):
    torch.manual_seed(2)
    network = build(config).to(memory_format=torch.channels_last)
    optimiser = torch.optim.SGD(network.parameters(), lr=0.1, momentum=0.9)
    return network, optimiser


@pytest.fixture(scope="module")
def data():
    network, optimiser = state()
    sum(p.sum() for p in network.parameters()).backward()
    optimiser.step()
    best = {name: tensor.clone() for name, tensor in network.state_dict().items()}
    progress = Progress(3, [[3, 0.1, 0.2, 0.3, None, None]], [0.1, 2], 0.25, 2)
    return snapshots.dump(network, optimiser, best, progress, SETTINGS)


def test_round_trip_is_exact(data):
    network, optimiser = state()
    best, progress = snapshots.restore(data, network, optimiser, SETTINGS)
    assert snapshots.dump(network, optimiser, best, progress, SETTINGS) == data
    assert progress.step == 3
    weight = network.backbone.conv1.weight
    assert optimiser.state[weight]["momentum_buffer"].stride() == weight.stride()


def test_other_settings_are_refused_and_named(data):
    other = {"params": {"learning_rate": 0.02, "crop": (96, 128)}, "inputs": {"train.csv": "cd"}}
    with pytest.raises(ValueError, match=r"inputs.train.csv: ab -> cd; params.learning_rate: 0.01 -> 0.02"):
        snapshots.restore(data, *state(), other)


def test_other_width_is_refused(data):
    with pytest.raises(ValueError, match="do not fit"):
        snapshots.restore(data, *state(NetworkConfig("bisenet", "resnet18", width=16, decoder=4)), SETTINGS)


def test_half_a_snapshot_is_refused(data):
    with pytest.raises(ValueError, match="cut off"):
        snapshots.restore(data[: len(data) // 2], *state(), SETTINGS)


def test_differences_reach_into_trees():
    assert differences({"a": {"b": 1}, "c": 2}, {"a": {"b": 3}, "d": 4}) == [
        "a.b: 1 -> 3",
        "c: 2 -> None",
        "d: None -> 4",
    ]
