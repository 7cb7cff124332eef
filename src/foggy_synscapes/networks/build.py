"""From a config to a module."""

from foggy_synscapes.networks.bisenet import BiSeNet
from foggy_synscapes.networks.config import NetworkConfig
from foggy_synscapes.networks.network import Network
from foggy_synscapes.networks.refinenet import RefineNet


def build(config: NetworkConfig) -> Network:
    """A network with random weights, drawn from PyTorch's global generator: seed it first for repeatable ones."""
    return {"refinenet": RefineNet, "bisenet": BiSeNet}[config.name](config)
