"""Segmentation networks: ResNet backbones, and the registered networks on them.

Importing this package is cheap: PyTorch is imported by the modules that need it (`build`, `weights`, ...).
"""

from foggy_synscapes.networks.config import BACKBONES, NETWORKS, NetworkConfig
from foggy_synscapes.networks.declaration import NetworkEntry

__all__ = ["BACKBONES", "NETWORKS", "NetworkConfig", "NetworkEntry", "titles"]


def titles() -> dict[str, str]:
    """What is printed for each network, by its name and in the order of the paper's tables.

    >>> titles()
    {'refinenet': 'RefineNet', 'bisenet': 'BiSeNet'}
    """
    entries = sorted((NETWORKS[name] for name in NETWORKS), key=lambda entry: (entry.order, entry.name))
    return {entry.name: entry.title for entry in entries}
