"""Models of fog: each a module that declares one, here or among the plugins."""

from foggy_synscapes.fog.models.model import FogModel
from foggy_synscapes.registry import Registry

__all__ = ["MODELS", "FogModel"]

MODELS: Registry[FogModel] = Registry("fog.models", "FOG_MODEL", "fog model")
