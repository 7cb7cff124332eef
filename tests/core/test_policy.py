"""Schedules and parameter groups follow the policy to the letter."""

import pytest
from policies import POLICY, changed

from foggy_synscapes.networks import NetworkConfig
from foggy_synscapes.networks.network import build
from foggy_synscapes.training.learner import parameter_groups, set_training


@pytest.fixture
def network():
    return build(NetworkConfig("bisenet", "resnet18", width=8, decoder=4))


def test_poly_begins_at_the_full_rate_and_ends_above_zero():
    assert POLICY.rate(0, 100) == 0.01
    assert POLICY.rate(99, 100) == pytest.approx(0.01 * 0.01**0.9)
    assert POLICY.rate(50, 100) == pytest.approx(0.01 * 0.5**0.9)


def test_constant_stays():
    assert {changed(POLICY, schedule="constant").rate(step, 10) for step in range(10)} == {0.01}


@pytest.mark.parametrize("step", [-1, 100])
def test_step_outside_of_the_schedule_is_refused(step):
    with pytest.raises(ValueError, match="step"):
        POLICY.rate(step, 100)


def test_every_parameter_is_in_one_group_with_its_rate_and_decay(network):
    names = {id(parameter): name for name, parameter in network.named_parameters()}
    seen = {}
    for group in parameter_groups(network, POLICY):
        for parameter in group["params"]:
            name = names[id(parameter)]
            assert name not in seen
            seen[name] = (group["factor"], group["weight_decay"])
    assert set(seen) == set(names.values())
    assert seen["backbone.conv1.weight"] == (1.0, 0.0005)
    assert seen["backbone.bn1.weight"] == (1.0, 0.0)
    assert seen["head.classifier.weight"] == (10.0, 0.0005)
    assert seen["head.classifier.bias"] == (10.0, 0.0)


def test_frozen_batch_norm_neither_learns_nor_counts(network):
    set_training(network, changed(POLICY, freeze_batch_norm=True))
    assert network.training
    assert not network.backbone.bn1.training
    grouped = {id(p) for group in parameter_groups(network, POLICY) for p in group["params"]}
    assert id(network.backbone.bn1.weight) not in grouped
    assert id(network.backbone.conv1.weight) in grouped
