"""What both networks share: outputs below full resolution for training, full resolution for everyone else."""

import torch.nn.functional as functional
from torch import Tensor, nn

from foggy_synscapes.networks.config import NETWORKS, STRIDE, NetworkConfig


def resize(maps: Tensor, size: tuple[int, ...], corners: bool = True) -> Tensor:
    """Bilinear resizing (B, C, h, w) -> (B, C, H, W); `corners`: centres of corner pixels stay on each other."""
    if tuple(maps.shape[-2:]) == tuple(size):
        return maps
    return functional.interpolate(maps, size=size, mode="bilinear", align_corners=corners)


def padded(images: Tensor) -> Tensor:
    """Repeats the last row and column until both sides are multiples of the stride; (B, 3, H, W) images."""
    height, width = images.shape[-2:]
    if height < 1 or width < 1:
        raise ValueError(f"images: {height} x {width} pixels, expected at least one")
    below, right = -height % STRIDE, -width % STRIDE
    return functional.pad(images, (0, right, 0, below), mode="replicate") if below or right else images


class Network(nn.Module):
    """A segmentation network.

    `backbone` is the part that public weights exist for; everything else counts as new layers.
    """

    config: NetworkConfig
    backbone: nn.Module
    corners = True  # how logits are enlarged, see `resize`

    def outputs(self, images: Tensor) -> list[Tensor]:
        """Logits below full resolution: the main output first, then, while training, the auxiliary ones.

        images : (B, 3, H, W), normalised, H and W multiples of 32
        """
        raise TypeError(f"{type(self).__name__} defines no outputs")

    def forward(self, images: Tensor) -> Tensor:
        """images (B, 3, H, W), normalised, any size -> logits (B, classes, H, W)."""
        whole = padded(images)
        logits = resize(self.outputs(whole)[0], tuple(whole.shape[-2:]), self.corners)
        return logits[..., : images.shape[-2], : images.shape[-1]]


def build(config: NetworkConfig) -> Network:
    """A network with random weights, drawn from PyTorch's global generator: seed it first for repeatable ones."""
    return NETWORKS[config.name].build(config)
