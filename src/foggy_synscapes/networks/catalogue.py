"""What the networks cost at their published sizes."""

from dataclasses import replace
from typing import Any

import torch
from torch.utils.flop_counter import FlopCounterMode

from foggy_synscapes.networks.config import NETWORKS, NetworkConfig, titles
from foggy_synscapes.networks.network import build


def multiply_adds(config: NetworkConfig, size: tuple[int, int] = (512, 1024)) -> int:
    """Multiplications with addition in the convolutions of one forward pass in evaluation, for one image.

    size : rows and columns. Nothing is computed: the shapes are followed on PyTorch's meta device.
    """
    with torch.device("meta"), torch.no_grad(), FlopCounterMode(display=False) as counter:
        build(config).eval()(torch.empty(1, 3, *size))
    return counter.get_total_flops() // 2  # it counts both


def parameters(config: NetworkConfig) -> int:
    """Number of trained values of a network; running statistics of batch norm are not counted."""
    with torch.device("meta"):
        return sum(parameter.numel() for parameter in build(config).parameters())


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
