"""Figures, one module each: a new one is a module that assigns FIGURE."""

from foggy_synscapes.figures.figure import Figure
from foggy_synscapes.registry import Registry

FIGURES: Registry[Figure] = Registry("figures", "FIGURE", "figure")
