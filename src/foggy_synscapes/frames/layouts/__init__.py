"""Layouts of datasets, each a module that declares one: which frames a folder holds, and what is made of them."""

from foggy_synscapes.frames.layouts.layout import Layout, Request, Wanted
from foggy_synscapes.registry import Registry

__all__ = ["LAYOUTS", "Layout", "Request", "Wanted"]

LAYOUTS: Registry[Layout] = Registry("frames.layouts", "LAYOUT", "layout")
