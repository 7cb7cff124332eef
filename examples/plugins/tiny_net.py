"""A network: a ResNet, and one layer that names the class of each cell of its third feature map.

This file's name is the network's name. PyTorch is imported when the network is built, because files like this one are
read to list names, too.
"""

from typing import TYPE_CHECKING

from foggy_synscapes.networks import NetworkConfig, NetworkEntry

if TYPE_CHECKING:
    from foggy_synscapes.networks.network import Network


def build(config: NetworkConfig) -> "Network":
    """The module, with random weights. Larger networks keep their layers in a file of their own beside this one."""
    import torch
    from torch import nn

    from foggy_synscapes.networks.network import Network
    from foggy_synscapes.networks.resnet import ResNet

    class TinyNet(Network):
        """Logits at a 16th of the resolution; `Network` enlarges them."""

        def __init__(self) -> None:
            super().__init__()
            self.config = config
            self.backbone = ResNet(config.backbone, config.width, config.stride_in)
            self.between = nn.Conv2d(self.backbone.channels[2], config.decoder, 1)
            self.classifier = nn.Conv2d(config.decoder, config.classes, 1)

        def outputs(self, images: torch.Tensor) -> list[torch.Tensor]:
            return [self.classifier(torch.relu(self.between(self.backbone(images)[2])))]

    return TinyNet()


NETWORK = NetworkEntry("tiny_net", title="TinyNet", order=2, backbone="resnet18", width=64, decoder=64, build=build)
