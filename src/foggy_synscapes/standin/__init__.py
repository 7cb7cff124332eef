"""The stand-in's street renderer: arrays out, decided by a seed alone."""

from foggy_synscapes.standin.render import Scene, render

__all__ = ["Scene", "render"]
