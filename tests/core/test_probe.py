"""The arithmetic is chosen by what was measured, and what was measured is told."""

import math
from dataclasses import replace

import numpy as np
import policies
import pytest
import torch

from foggy_synscapes.networks import NetworkConfig
from foggy_synscapes.networks.build import build
from foggy_synscapes.networks.weights import Preprocessing, dump
from foggy_synscapes.training import probe
from foggy_synscapes.training.forward import Arithmetic
from foggy_synscapes.training.ranks import ALONE

pytestmark = pytest.mark.usefixtures("one_thread")

EXACT, SHORT = Arithmetic(precision="float32"), Arithmetic(precision="bfloat16")
PLAIN = Arithmetic(memory_format="contiguous")


class Samples:
    """Four grey images."""

    count = 4

    def load(self, index):
        return np.full((32, 32, 3), index, np.uint8), np.zeros((32, 32), np.uint8)

    def name(self, index):
        return str(index)


def chosen(monkeypatch, times):
    """What is chosen, and told, where the arithmetics take these times."""
    with monkeypatch.context() as patch:
        patch.setattr(probe, "seconds", lambda *arguments: times[arguments[3]])
        return probe.fastest(torch.nn.Linear(1, 1), Preprocessing(), policies.POLICY, [*times], Samples(), 0)


@pytest.mark.parametrize(("short", "taken"), [(0.080, SHORT), (0.095, EXACT), (math.inf, EXACT)])
def test_bfloat16_must_be_a_tenth_faster(monkeypatch, short, taken):
    assert chosen(monkeypatch, {EXACT: 0.1, SHORT: short})[0] == taken


def test_the_faster_layout_is_taken_and_all_figures_are_told(monkeypatch):
    found, told = chosen(monkeypatch, {EXACT: 0.1, PLAIN: 0.098})
    assert found == PLAIN
    assert told == (
        "a step takes with float32 channels_last 100.0 ms, float32 contiguous 98.0 ms (median of 5); "
        "chosen: float32 contiguous"
    )


def test_measuring_leaves_the_network_as_it_was():
    network = build(NetworkConfig("bisenet", "resnet18", width=8, decoder=4))
    before = dump(network, Preprocessing())
    found, _ = probe.fastest(network, Preprocessing(), policies.POLICY, [EXACT, SHORT], Samples(), 0)
    assert found in (EXACT, SHORT)
    assert dump(network, Preprocessing()) == before


def test_an_arithmetic_whose_loss_is_no_number_takes_for_ever():
    network = build(NetworkConfig("bisenet", "resnet18", width=8, decoder=4))
    with torch.no_grad():
        network.head.classifier.bias.fill_(math.nan)
    policy = replace(policies.POLICY, loss="cross_entropy")
    assert probe.seconds(network, Preprocessing(), policy, EXACT, Samples(), 0, ALONE) == math.inf
