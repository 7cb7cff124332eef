"""Segmentation networks: ResNet backbones, RefineNet and BiSeNet.

Importing this package is cheap: PyTorch is imported by the modules that need it (`build`, `weights`, ...).
"""

from foggy_synscapes.networks.config import BACKBONES, PUBLISHED, NetworkConfig

__all__ = ["BACKBONES", "PUBLISHED", "NetworkConfig"]
