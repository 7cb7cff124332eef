"""Backbones have the published layout: names, counts and strides."""

import subprocess
import sys

import pytest
import torch

from foggy_synscapes.networks.resnet import SAFE, ResNet, Shortcut

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


@pytest.mark.parametrize("channels", [4, SAFE - 4, SAFE])
def test_a_shortcut_is_the_convolution_that_it_stands_for(channels):
    torch.manual_seed(0)
    images = torch.randn(2, channels, 9, 12)
    shortcut = Shortcut(channels, 8, 1, 2, bias=False)
    expected = torch.nn.functional.conv2d(images, shortcut.weight, stride=2)
    assert torch.allclose(shortcut(images), expected, atol=1e-6)


# At this size PyTorch's own gradient of a shortcut of 8 channels ends the process, so it is tried in another one.
GRADIENT = """
import torch
from foggy_synscapes.networks.resnet import ResNet
found = []
for layout in (torch.channels_last, torch.contiguous_format):
    torch.manual_seed(0)
    network = ResNet("resnet18", width=8).to(memory_format=layout)
    images = torch.randn(1, 3, 304, 304).contiguous(memory_format=layout)
    sum(maps.square().mean() for maps in network(images)).backward()
    found.append(network.layer2[0].downsample[0].weight.grad)
assert torch.allclose(*found, rtol=1e-3, atol=1e-6), (found[0] - found[1]).abs().max()
"""


def test_gradients_of_a_narrow_network_are_the_same_in_either_layout_of_memory():
    ended = subprocess.run([sys.executable, "-c", GRADIENT], capture_output=True, text=True, check=False)
    assert ended.returncode == 0, f"{ended.returncode}: {ended.stderr}"
