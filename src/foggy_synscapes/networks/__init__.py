"""Segmentation networks. Importing this package is cheap: the modules that compute import PyTorch."""

from foggy_synscapes.networks.config import BACKBONES, NETWORKS, NetworkConfig, NetworkEntry, titles

__all__ = ["BACKBONES", "NETWORKS", "NetworkConfig", "NetworkEntry", "titles"]
