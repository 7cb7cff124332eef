"""Fog: optics, geometry and the atmospheric light. Arrays in, arrays out; knows no path.

The package itself can be called: `foggy_synscapes.fog(image, depth, beta=0.02, camera=...)` puts fog on an image. See
`help(foggy_synscapes.api.fog)`.
"""

import importlib
import sys
from types import ModuleType
from typing import Any


class _Callable(ModuleType):
    """A package with the name of a function that it would hide, so it does what the function does."""

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        return importlib.import_module("foggy_synscapes.api").fog(*arguments, **options)


sys.modules[__name__].__class__ = _Callable
