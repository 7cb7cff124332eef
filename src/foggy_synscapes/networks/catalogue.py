"""What the networks cost at their published sizes."""

from dataclasses import replace
from typing import Any

import torch
from torch import nn

from foggy_synscapes.networks import NETWORKS, NetworkConfig, titles
from foggy_synscapes.networks.build import build

SIZE = (512, 1024)  # pixels, rows and columns, at which networks of this field are compared


def multiply_adds(config: NetworkConfig, size: tuple[int, int] = SIZE) -> int:
    """Multiplications with addition in the convolutions of one forward pass in evaluation, for one image.

    size : rows and columns. Nothing is computed: the shapes are followed on PyTorch's meta device.
    """
    with torch.device("meta"):
        network = build(config).eval()
        images = torch.empty(1, 3, *size)
    counts: list[int] = []

    def count(layer: nn.Conv2d, _inputs: tuple, output: torch.Tensor) -> None:
        counts.append(output.numel() * layer.weight[0].numel())

    for layer in network.modules():
        if isinstance(layer, nn.Conv2d):
            layer.register_forward_hook(count)
    with torch.no_grad():
        network(images)
    return sum(counts)


def parameters(config: NetworkConfig) -> int:
    """Number of trained values of a network."""
    with torch.device("meta"):
        return build(config).parameter_count()


def catalogue() -> list[dict[str, Any]]:
    """One entry per network at its published size, in the order of the paper's tables."""
    return [
        {
            "name": name,
            "backbone": config.backbone,
            "parameters": parameters(config),
            "parameters_without_auxiliary_heads": parameters(replace(config, auxiliary=False)),
            "multiply_adds_1024x512": multiply_adds(config),
        }
        for name, config in ((name, NETWORKS[name].published) for name in titles())
    ]
