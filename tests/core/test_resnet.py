"""Backbones have the published layout: names, counts and strides."""

import pytest
import torch

from foggy_synscapes.networks.resnet import ResNet

# Parameters of torchvision's models without their classifier.
PUBLISHED = {"resnet18": 11_176_512, "resnet34": 21_284_672, "resnet50": 23_508_032, "resnet101": 42_500_160}


@pytest.mark.parametrize("name", PUBLISHED)
def test_count_of_parameters_is_the_published_one(name):
    with torch.device("meta"):
        network = ResNet(name)
    assert sum(parameter.numel() for parameter in network.parameters()) == PUBLISHED[name]


def test_names_are_those_of_torchvision():
    with torch.device("meta"):
        names = set(ResNet("resnet50").state_dict())
    assert {"conv1.weight", "bn1.running_var", "layer1.0.downsample.1.bias", "layer4.2.conv3.weight"} <= names
    assert not any(name.startswith("fc") for name in names)


@pytest.mark.parametrize("name", ["resnet18", "resnet50"])
def test_maps_have_strides_4_to_32(name):
    network = ResNet(name, width=4).eval()
    maps = network(torch.zeros(1, 3, 64, 96))
    assert [tuple(m.shape[2:]) for m in maps] == [(16, 24), (8, 12), (4, 6), (2, 3)]
    assert [m.shape[1] for m in maps] == network.channels
