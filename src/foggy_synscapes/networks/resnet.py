"""ResNet backbones that return the feature maps of their four stages.

Source: He et al., Deep Residual Learning for Image Recognition, CVPR 2016. Parameter names are torchvision's.
"""

import torch
import torch.nn.functional as functional
from torch import Tensor, nn

from foggy_synscapes.networks.config import BACKBONES

SAFE = 16
"""Channels from which the gradient of a 1x1 convolution with stride is computed within its memory."""


class Shortcut(nn.Conv2d):
    """A 1x1 convolution with stride, and without padding or bias.

    With fewer than 16 input channels oneDNN writes the gradient of its weights past the end of its memory, which is a
    crash or wrong numbers (oneDNN issue 6035, channels last). Without a stride it does not, so of few channels the
    pixels that count are taken out first.
    """

    def forward(self, x: Tensor) -> Tensor:
        if self.in_channels >= SAFE:
            return super().forward(x)
        down, right = self.stride
        return functional.conv2d(x[..., ::down, ::right], self.weight)


class Block(nn.Module):
    """A residual block: two 3x3 convolutions, or a bottleneck of 1x1, 3x3 and 1x1 with four times the channels."""

    downsample: nn.Sequential | None

    def __init__(self, inputs: int, channels: int, stride: int, bottleneck: bool, stride_in: str) -> None:
        super().__init__()
        outputs = channels * 4 if bottleneck else channels
        first, second = (stride, 1) if stride_in == "1x1" else (1, stride)
        shapes = (
            [(inputs, channels, 1, first), (channels, channels, 3, second), (channels, outputs, 1, 1)]
            if bottleneck
            else [(inputs, channels, 3, stride), (channels, outputs, 3, 1)]
        )
        self.depth = len(shapes)
        for number, (before, after, kernel, step) in enumerate(shapes, start=1):
            convolution = nn.Conv2d(before, after, kernel, step, padding=kernel // 2, bias=False)
            self.add_module(f"conv{number}", convolution)
            self.add_module(f"bn{number}", nn.BatchNorm2d(after))
        if stride != 1 or inputs != outputs:
            self.downsample = nn.Sequential(Shortcut(inputs, outputs, 1, stride, bias=False), nn.BatchNorm2d(outputs))
        else:
            self.downsample = None

    def forward(self, x: Tensor) -> Tensor:
        y = x
        for number in range(1, self.depth + 1):
            y = getattr(self, f"bn{number}")(getattr(self, f"conv{number}")(y))
            if number < self.depth:
                y = torch.relu_(y)
        shortcut = x if self.downsample is None else self.downsample(x)
        return torch.relu_(y.add_(shortcut))


class ResNet(nn.Module):
    """The convolutional part of a ResNet.

    name : key of `BACKBONES`; width : channels of the first stage, 64 as published
    stride_in : "3x3" or "1x1", see `NetworkConfig`
    channels : channels of the four outputs, of strides 4, 8, 16 and 32
    """

    def __init__(self, name: str, width: int = 64, stride_in: str = "3x3") -> None:
        super().__init__()
        depths, bottleneck = BACKBONES[name]
        self.conv1 = nn.Conv2d(3, width, 7, 2, padding=3, bias=False)
        self.bn1 = nn.BatchNorm2d(width)
        self.maxpool = nn.MaxPool2d(3, 2, padding=1)
        self.channels: list[int] = []
        inputs = width
        for stage, depth in enumerate(depths):
            channels = width * 2**stage
            blocks = []
            for number in range(depth):
                stride = 2 if stage > 0 and number == 0 else 1
                blocks.append(Block(inputs, channels, stride, bottleneck, stride_in))
                inputs = channels * 4 if bottleneck else channels
            self.add_module(f"layer{stage + 1}", nn.Sequential(*blocks))
            self.channels.append(inputs)
        for module in self.modules():
            # Tensors without storage take no values; drawing some would load the compiler, for two seconds.
            if isinstance(module, nn.Conv2d) and not module.weight.is_meta:
                nn.init.kaiming_normal_(module.weight, mode="fan_out", nonlinearity="relu")

    def forward(self, images: Tensor) -> list[Tensor]:
        """images (B, 3, H, W), normalised -> feature maps of strides 4, 8, 16 and 32."""
        x = self.maxpool(torch.relu_(self.bn1(self.conv1(images))))
        maps = []
        for stage in range(1, 5):
            x = getattr(self, f"layer{stage}")(x)
            maps.append(x)
        return maps
