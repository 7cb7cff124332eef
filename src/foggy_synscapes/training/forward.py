"""From 8-bit images and labels to a network's outputs and the targets beside them."""

from collections.abc import Callable
from dataclasses import dataclass

import torch
import torch.nn.functional as functional
from torch import Tensor

from foggy_synscapes.networks.network import Network, padded
from foggy_synscapes.networks.weights import Preprocessing
from foggy_synscapes.training.losses import IGNORE, grid


class NotFiniteError(ValueError):
    """A loss is infinite or no number; the message names the samples."""


@dataclass(frozen=True)
class Arithmetic:
    """Where and on which numbers a network computes.

    device : "cpu" or "cuda"; precision : "float32", or "bfloat16" (autocast: weights stay float32)
    memory_format : "channels_last", in which convolutions on processors are faster, or "contiguous"
    compile : train on the network compiled by `torch.compile`; validation stays as it is, for images of any size
    """

    device: str = "cpu"
    precision: str = "float32"
    memory_format: str = "channels_last"
    compile: bool = False

    def layout(self) -> torch.memory_format:
        """PyTorch's name for the memory format."""
        return torch.channels_last if self.memory_format == "channels_last" else torch.contiguous_format

    def place(self, network: Network) -> None:
        """Bring a network to the device and into the layout."""
        network.to(device=self.device, memory_format=self.layout())  # type: ignore[call-overload]  # as in load_model


def forward(
    network: Network,
    preprocessing: Preprocessing,
    arithmetic: Arithmetic,
    stride: int,
    images: Tensor,
    labels: Tensor,
    outputs: Callable[[Tensor], list[Tensor]] | None = None,
) -> tuple[list[Tensor], Tensor]:
    """Outputs of a network, and the targets that a loss of a stride compares them with.

    images : uint8 (B, 3, H, W); labels : uint8 (B, H, W). Both are padded to the network's stride, labels with ignored
    pixels. outputs : called instead of the network's own `outputs`, which it wraps
    Returns the network's outputs (see `Network.outputs`) and targets uint8 (B, h, w) (see `losses.grid`).
    """
    inputs = padded(preprocessing.apply(images.to(arithmetic.device, non_blocking=True)))
    # Not `outputs or ...`: a module that is a wrapper may be false.
    compute = network.outputs if outputs is None else outputs
    with torch.autocast(arithmetic.device, torch.bfloat16, enabled=arithmetic.precision == "bfloat16"):
        found = compute(inputs.contiguous(memory_format=arithmetic.layout()))
    below, right = inputs.shape[-2] - labels.shape[-2], inputs.shape[-1] - labels.shape[-1]
    labels = functional.pad(labels.to(arithmetic.device, non_blocking=True), (0, right, 0, below), value=IGNORE)
    return found, grid(labels, stride, network.corners)
