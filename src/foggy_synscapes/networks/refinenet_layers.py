"""RefineNet: a ResNet whose four feature maps are fused from the coarsest to the finest.

Source: Lin et al., RefineNet: Multi-Path Refinement Networks for High-Resolution Semantic Segmentation, CVPR 2017.
The counts of units (2 before the fusion, 3 after the pooling), the four-fold chained pooling, the dropout and the
missing batch norm of the decoder are those of the released models.
"""

import torch
from torch import Tensor, nn

from foggy_synscapes.networks.config import NetworkConfig
from foggy_synscapes.networks.network import Network, resize
from foggy_synscapes.networks.resnet import ResNet


def convolution(inputs: int, outputs: int, bias: bool = False) -> nn.Conv2d:
    return nn.Conv2d(inputs, outputs, 3, padding=1, bias=bias)


class ResidualUnit(nn.Module):
    """x + conv(relu(conv(relu(x)))): only the first convolution has a bias."""

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.first = convolution(channels, channels, bias=True)
        self.second = convolution(channels, channels)

    def forward(self, x: Tensor) -> Tensor:
        return self.second(torch.relu_(self.first(torch.relu(x)))).add_(x)


class ChainedPooling(nn.Module):
    """Adds to the input a chain of (5x5 maximum, 3x3 convolution), each link to the sum."""

    def __init__(self, channels: int, links: int = 4) -> None:
        super().__init__()
        self.pool = nn.MaxPool2d(5, 1, padding=2)
        self.links = nn.ModuleList(convolution(channels, channels) for _ in range(links))

    def forward(self, x: Tensor) -> Tensor:
        link, total = x, x
        for layer in self.links:
            link = layer(self.pool(link))
            total = total + link
        return total


class Level(nn.Module):
    """One refinement block: reduce, adapt, fuse with the coarser level, pool, refine.

    inputs : channels of the backbone's map; channels : of this level; coarser : of the level below, None for the
    deepest, which has nothing to fuse
    """

    def __init__(self, inputs: int, channels: int, coarser: int | None) -> None:
        super().__init__()
        self.reduce = convolution(inputs, channels)
        self.adapt = nn.Sequential(ResidualUnit(channels), ResidualUnit(channels))
        if coarser is not None:
            self.fuse_fine = convolution(channels, channels)
            self.fuse_coarse = convolution(coarser, channels)
        self.pool = ChainedPooling(channels)
        self.refine = nn.Sequential(*(ResidualUnit(channels) for _ in range(3)))

    def forward(self, features: Tensor, coarse: Tensor | None) -> Tensor:
        x = self.adapt(self.reduce(features))
        if coarse is not None:
            x = self.fuse_fine(x)
            x = x + resize(self.fuse_coarse(coarse), tuple(x.shape[-2:]))
        return self.refine(self.pool(torch.relu(x)))


class RefineNet(Network):
    """RefineNet on any ResNet; `config.decoder` channels (twice as many at the deepest level), output stride 4."""

    def __init__(self, config: NetworkConfig) -> None:
        super().__init__()
        self.config = config
        self.backbone = ResNet(config.backbone, config.width, config.stride_in)
        channels = [config.decoder] * 3 + [config.decoder * 2]
        self.levels = nn.ModuleList(  # of strides 4, 8, 16 and 32
            Level(self.backbone.channels[i], channels[i], channels[i + 1] if i < 3 else None) for i in range(4)
        )
        self.dropout = nn.Dropout(0.5)
        self.head = convolution(config.decoder, config.classes, bias=True)
        self._scale_down_branches()

    def _scale_down_branches(self) -> None:
        """Start every residual branch and the head ten times smaller.

        Without batch norm the branches of the decoder add up, and training from random weights diverges at rates at
        which it does not so. Weights that are loaded are not touched by this.
        """
        with torch.no_grad():
            for module in self.levels.modules():
                if isinstance(module, ResidualUnit):
                    module.second.weight.mul_(0.1)
                elif isinstance(module, ChainedPooling):
                    for weight in module.links.parameters():
                        weight.mul_(0.1)
            self.head.weight.mul_(0.1)

    def outputs(self, images: Tensor) -> list[Tensor]:
        maps = self.backbone(images)
        maps[2:] = [self.dropout(features) for features in maps[2:]]
        x = None
        for level, features in zip(reversed(self.levels), reversed(maps), strict=True):
            x = level(features, x)
        return [self.head(self.dropout(x))]
