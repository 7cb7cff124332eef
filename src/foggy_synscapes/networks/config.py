"""What a network is made of and what declares one, without PyTorch: names are listed from here, too."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from foggy_synscapes.registry import Registry

if TYPE_CHECKING:
    from torch import Tensor

    from foggy_synscapes.networks.layouts import Layout
    from foggy_synscapes.networks.network import Network

# Blocks of each stage, and whether they are bottlenecks. Source: He et al. 2016, table 1.
BACKBONES: dict[str, tuple[tuple[int, int, int, int], bool]] = {
    "resnet18": ((2, 2, 2, 2), False),
    "resnet34": ((3, 4, 6, 3), False),
    "resnet50": ((3, 4, 6, 3), True),
    "resnet101": ((3, 4, 23, 3), True),
}

NETWORKS: "Registry[NetworkEntry]" = Registry("networks", "NETWORK", "network")
"""The networks, each a module of this package or a plugin."""

NARROWEST = 8
"""Channels of the first stage at least.

Below 8 the gradient of the 1x1 convolution with stride 2 that follows it is written past the end of its memory on
processors with AVX2 and no AVX-512: PyTorch 2.13 has oneDNN 3.12, see uxlfoundation/oneDNN issue 6035.
"""
STRIDE = 32  # pixels of the input for one of the deepest feature map, in every network


@dataclass(frozen=True)
class NetworkConfig:
    """The architecture of one network; two equal configs give modules with the same parameter names and shapes.

    width : channels of the first stage (64 as published; later stages double it), at least 8, see `NARROWEST`
    decoder : channels of what follows the backbone, as the network's layers say
    auxiliary : has the heads that are used in training alone, where the network has such
    variant : which public formulation, where the network has several
    stride_in : which convolution of a bottleneck has the stride: "3x3" (torchvision) or "1x1" (Caffe, MatConvNet)

    Raises ValueError naming the field that cannot be.
    """

    name: str
    backbone: str
    width: int = 64
    decoder: int = 128
    classes: int = 19
    auxiliary: bool = True
    variant: str = "torchseg"  # every model file records one, also of a network that has only one formulation
    stride_in: str = "3x3"

    def __post_init__(self) -> None:
        for key, known in (("name", NETWORKS), ("backbone", BACKBONES), ("stride_in", ("3x3", "1x1"))):
            if getattr(self, key) not in known:
                raise ValueError(f"{key}: {getattr(self, key)!r}, expected one of {', '.join(known)}")
        for key, least in (("width", NARROWEST), ("decoder", 4), ("classes", 2)):
            value = getattr(self, key)
            if not isinstance(value, int) or value < least:
                raise ValueError(f"{key}: {value!r}, expected a whole number of at least {least}")
        NETWORKS[self.name].check(self)


@dataclass(frozen=True)
class Preprocessing:
    """What turns 8-bit RGB into a network's input: (value * scale - mean) / std, per channel in the given order.

    The default is ImageNet's mean and standard deviation, which torchvision's, TorchSeg's and CoinCheung's weights use.
    """

    channels: str = "RGB"
    scale: float = 1 / 255
    mean: tuple[float, float, float] = (0.485, 0.456, 0.406)
    std: tuple[float, float, float] = (0.229, 0.224, 0.225)

    def __post_init__(self) -> None:
        if self.channels not in ("RGB", "BGR"):
            raise ValueError(f"preprocessing: channels {self.channels!r}, expected RGB or BGR")
        if len(self.mean) != 3 or len(self.std) != 3 or min(self.std) <= 0:
            raise ValueError(f"preprocessing: mean {self.mean} and std {self.std}, expected three each, std above 0")

    def apply(self, images: "Tensor") -> "Tensor":
        """uint8 (B, 3, H, W) in RGB order -> float32 of the same shape, pixel by pixel in memory."""
        import torch

        if self.channels == "BGR":
            images = images.flip(1)
        batch, _, height, width = images.shape
        std, mean = (torch.tensor(values, dtype=torch.float64) for values in (self.std, self.mean))
        # Constants as long as a row: with three of them the innermost loop would have three steps only.
        rows = (values.float().repeat(width) for values in (self.scale / std, -mean / std))
        factor, offset = (row.to(images.device, non_blocking=True) for row in rows)
        pixels = images.permute(0, 2, 3, 1).reshape(batch, height, width * 3).to(torch.float32)
        return pixels.mul_(factor).add_(offset).view(batch, height, width, 3).permute(0, 3, 1, 2)


@dataclass(frozen=True)
class NetworkEntry:
    """A network of the registry. Its module is named like it and assigns it to `NETWORK`; its layers are in another.

    title : as printed; order : place in lists, from 0, where the paper's tables have it
    backbone, width, decoder : the published size, see `NetworkConfig`
    build : config -> module with random weights; imports the layers, and with them PyTorch
    head : our name of a parameter of the heads used in training alone; None for a network without such
    sizes : fields of the config that a file's tensors tell: for each, our name of a tensor, and its axis
    layouts : the ways in which public weights of it are named
    check : raises ValueError, naming the field, for a config that this network cannot have
    """

    name: str
    title: str
    order: int
    backbone: str
    width: int
    decoder: int
    build: Callable[[NetworkConfig], "Network"]
    head: str | None = None
    sizes: Mapping[str, tuple[str, int]] = field(default_factory=dict)
    layouts: "tuple[Layout, ...]" = ()
    check: Callable[[NetworkConfig], None] = lambda _config: None

    @property
    def published(self) -> NetworkConfig:
        """The config of the published size, with the heads that training uses."""
        return NetworkConfig(self.name, self.backbone, self.width, self.decoder, auxiliary=self.head is not None)


def titles() -> dict[str, str]:
    """What is printed for each network, by its name and in the order of the paper's tables.

    >>> titles()
    {'refinenet': 'RefineNet', 'bisenet': 'BiSeNet'}
    """
    entries = sorted((NETWORKS[name] for name in NETWORKS), key=lambda entry: (entry.order, entry.name))
    return {entry.name: entry.title for entry in entries}
