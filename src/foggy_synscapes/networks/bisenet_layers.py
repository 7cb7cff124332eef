"""BiSeNet v1: a shallow spatial path beside a ResNet context path.

Source: Yu et al., BiSeNet: Bilateral Segmentation Network for Real-time Semantic Segmentation, ECCV 2018, with the
channel counts of the two public formulations (the authors' own TorchSeg, and CoinCheung's).
"""

import torch
import torch.nn.functional as functional
from torch import Tensor, nn

from foggy_synscapes.networks.config import NetworkConfig
from foggy_synscapes.networks.network import Network, resize
from foggy_synscapes.networks.resnet import ResNet


class PooledNorm(nn.BatchNorm2d):
    """Batch norm that also takes a single value per channel: a pooled map of one image has no variance of its own.

    Such a value is normalised by the running statistics, as in evaluation, and moves them: the mean towards itself, the
    variance towards its squared distance from that mean. So passes of one image see the statistics of those before.
    """

    def forward(self, x: Tensor) -> Tensor:
        if not self.training or x[:, 0].numel() > 1:
            return super().forward(x)
        mean, variance, momentum = self.running_mean, self.running_var, self.momentum
        assert mean is not None
        assert variance is not None
        assert momentum is not None
        normalised = functional.batch_norm(x, mean.clone(), variance.clone(), self.weight, self.bias, eps=self.eps)
        with torch.no_grad():
            value = x.detach().flatten().to(mean.dtype)
            variance.lerp_((value - mean).square(), momentum)
            mean.lerp_(value, momentum)
        return normalised


class Unit(nn.Module):
    """Convolution without bias, batch norm, and a ReLU unless told otherwise; `pooled` maps may be of one pixel."""

    def __init__(
        self, inputs: int, outputs: int, kernel: int, stride: int = 1, relu: bool = True, pooled: bool = False
    ) -> None:
        super().__init__()
        self.conv = nn.Conv2d(inputs, outputs, kernel, stride, padding=kernel // 2, bias=False)
        self.bn = (PooledNorm if pooled else nn.BatchNorm2d)(outputs)
        self.relu = relu

    def forward(self, x: Tensor) -> Tensor:
        x = self.bn(self.conv(x))
        return torch.relu_(x) if self.relu else x


def pooled(x: Tensor) -> Tensor:
    """Mean over all pixels: (B, C, H, W) -> (B, C, 1, 1)."""
    return x.mean(dim=(2, 3), keepdim=True)


class AttentionRefinement(nn.Module):
    """3x3 convolution whose channels are weighed by what the whole image holds."""

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__()
        self.features = Unit(inputs, outputs, 3)
        self.attention = Unit(outputs, outputs, 1, relu=False, pooled=True)

    def forward(self, x: Tensor) -> Tensor:
        x = self.features(x)
        return x * torch.sigmoid(self.attention(pooled(x)))


class FeatureFusion(nn.Module):
    """Joins the two paths and adds the joint channels once more, weighed by what the whole image holds.

    perceptron : two 1x1 convolutions with a ReLU between give the weights (TorchSeg); otherwise one with batch norm
    """

    attention: nn.Module

    def __init__(self, inputs: int, outputs: int, perceptron: bool) -> None:
        super().__init__()
        self.features = Unit(inputs, outputs, 1)
        if perceptron:
            self.attention = nn.Sequential(
                nn.Conv2d(outputs, outputs, 1, bias=False), nn.ReLU(), nn.Conv2d(outputs, outputs, 1, bias=False)
            )
        else:
            self.attention = Unit(outputs, outputs, 1, relu=False, pooled=True)

    def forward(self, spatial: Tensor, context: Tensor) -> Tensor:
        x = self.features(torch.cat([spatial, context], dim=1))
        return x + x * torch.sigmoid(self.attention(pooled(x)))


class Head(nn.Module):
    """3x3 unit and 1x1 classifier."""

    def __init__(self, inputs: int, middle: int, classes: int) -> None:
        super().__init__()
        self.features = Unit(inputs, middle, 3)
        self.classifier = nn.Conv2d(middle, classes, 1)

    def forward(self, x: Tensor) -> Tensor:
        return self.classifier(self.features(x))


class BiSeNet(Network):
    """BiSeNet v1, output stride 8, auxiliary outputs of strides 8 and 16.

    The two public formulations differ in these places only (counts at `decoder` = 128):

    | variant    | main head | auxiliary heads | attention of the fusion | resizing inside | of the output        |
    |------------|-----------|-----------------|-------------------------|-----------------|----------------------|
    | torchseg   | 64        | 256             | two convolutions        | bilinear        | corners on corners   |
    | coincheung | 256       | 64              | convolution, batch norm | nearest         | pixel areas on areas |
    """

    def __init__(self, config: NetworkConfig) -> None:
        super().__init__()
        self.config = config
        torchseg = config.variant == "torchseg"
        self.corners = torchseg
        width, decoder = config.width, config.decoder
        wide, narrow = decoder * 2, decoder // 2
        main, side = (narrow, wide) if torchseg else (wide, narrow)

        self.backbone = ResNet(config.backbone, width, config.stride_in)
        self.spatial = nn.Sequential(
            Unit(3, width, 7, 2), Unit(width, width, 3, 2), Unit(width, width, 3, 2), Unit(width, decoder, 1)
        )
        deep, deepest = self.backbone.channels[2:]
        self.whole = Unit(deepest, decoder, 1, pooled=True)
        self.attention32 = AttentionRefinement(deepest, decoder)
        self.attention16 = AttentionRefinement(deep, decoder)
        self.refine32 = Unit(decoder, decoder, 3)
        self.refine16 = Unit(decoder, decoder, 3)
        self.fusion = FeatureFusion(decoder * 2, decoder * 2, perceptron=torchseg)
        self.head = Head(decoder * 2, main, config.classes)
        if config.auxiliary:
            self.head16 = Head(decoder, side, config.classes)
            self.head32 = Head(decoder, side, config.classes)
        for name, module in self.named_modules():
            # Tensors without storage take no values; drawing some would load the compiler, for two seconds.
            if isinstance(module, nn.Conv2d) and not name.startswith("backbone.") and not module.weight.is_meta:
                nn.init.kaiming_normal_(module.weight, mode="fan_in", nonlinearity="relu")

    def _resize(self, x: Tensor, like: Tensor) -> Tensor:
        size = tuple(like.shape[-2:])
        if self.config.variant == "coincheung":
            return functional.interpolate(x, size=size, mode="nearest")
        return resize(x, size)

    def outputs(self, images: Tensor) -> list[Tensor]:
        _, map8, map16, map32 = self.backbone(images)
        # The mean of the whole image is one pixel: spreading it is the same whichever way it is resized.
        context32 = self.attention32(map32) + self.whole(pooled(map32))
        context16 = self.refine32(self._resize(context32, map16))
        context8 = self.refine16(self._resize(self.attention16(map16) + context16, map8))
        logits = [self.head(self.fusion(self.spatial(images), context8))]
        if self.training and self.config.auxiliary:
            logits += [self.head16(context8), self.head32(context16)]
        return logits
