"""What a network is made of, without PyTorch: read by parameters, the command line and the model files."""

from dataclasses import asdict, dataclass, fields
from typing import TYPE_CHECKING

from foggy_synscapes.registry import Registry

if TYPE_CHECKING:
    from foggy_synscapes.networks.declaration import NetworkEntry

# Blocks of each stage, and whether they are bottlenecks. Source: He et al. 2016, table 1.
BACKBONES: dict[str, tuple[tuple[int, int, int, int], bool]] = {
    "resnet18": ((2, 2, 2, 2), False),
    "resnet34": ((3, 4, 6, 3), False),
    "resnet50": ((3, 4, 6, 3), True),
    "resnet101": ((3, 4, 23, 3), True),
}

NETWORKS: "Registry[NetworkEntry]" = Registry("networks", "NETWORK", "network")
"""The networks, each a module of this package or a plugin; see `declaration.NetworkEntry`."""

NARROWEST = 8
"""Channels of the first stage at least.

Below 8 the gradient of the 1x1 convolution with stride 2 that follows it is written past the end of its memory on
processors with AVX2 and no AVX-512: PyTorch 2.13 has oneDNN 3.12, see uxlfoundation/oneDNN issue 6035.
"""
STRIDE = 32  # pixels of the input for one of the deepest feature map, in every network


@dataclass(frozen=True)
class NetworkConfig:
    """The architecture of one network; two equal configs give modules with the same parameter names and shapes.

    name : one of `NETWORKS`
    backbone : key of `BACKBONES`
    width : channels of the first stage (64 as published; later stages double it), at least 8, see `NARROWEST`
    decoder : channels of what follows the backbone, as the network's layers say
    classes : number of output classes
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
        if self.name not in NETWORKS:
            raise ValueError(f"name: {self.name!r}, expected one of {', '.join(NETWORKS)}")
        if self.backbone not in BACKBONES:
            raise ValueError(f"backbone: {self.backbone!r}, expected one of {', '.join(BACKBONES)}")
        if self.stride_in not in ("3x3", "1x1"):
            raise ValueError(f"stride_in: {self.stride_in!r}, expected 3x3 or 1x1")
        for key, least in (("width", NARROWEST), ("decoder", 4), ("classes", 2)):
            value = getattr(self, key)
            if not isinstance(value, int) or value < least:
                raise ValueError(f"{key}: {value!r}, expected a whole number of at least {least}")
        NETWORKS[self.name].check(self)

    def to_dict(self) -> dict[str, object]:
        """The fields as plain values, for JSON."""
        return asdict(self)

    @classmethod
    def from_dict(cls, values: dict[str, object]) -> "NetworkConfig":
        """The inverse of `to_dict`; raises ValueError for an unknown or a missing field."""
        known = {field.name for field in fields(cls)}
        if set(values) != known:
            unknown, missing = sorted(set(values) - known), sorted(known - set(values))
            raise ValueError(f"network config: unknown fields {unknown}, missing fields {missing}")
        return cls(**values)  # type: ignore[arg-type]
