"""From a config to a module."""

from foggy_synscapes.networks.config import NETWORKS, NetworkConfig
from foggy_synscapes.networks.network import Network


def build(config: NetworkConfig) -> Network:
    """A network with random weights, drawn from PyTorch's global generator: seed it first for repeatable ones."""
    return NETWORKS[config.name].build(config)
