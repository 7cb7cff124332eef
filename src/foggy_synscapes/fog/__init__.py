"""Fog: optics, geometry and the atmospheric light. Arrays in, arrays out; knows no path.

The package itself can be called: `foggy_synscapes.fog(image, depth, beta=0.02, camera=...)` puts fog on an image. See
`help(foggy_synscapes.api.fog)`.
"""

import importlib
import inspect
import sys
from types import ModuleType
from typing import Any


class _Callable(ModuleType):
    """A package with the name of a function that it would hide, so it does and explains what the function does."""

    @property
    def __signature__(self) -> inspect.Signature:
        return inspect.signature(importlib.import_module("foggy_synscapes.api").fog)

    @property
    def __doc__(self) -> str:  # type: ignore[override]
        function = inspect.getdoc(importlib.import_module("foggy_synscapes.api").fog) or ""
        # Its examples are the function's, where tests run them.
        return f"{self.__dict__['__doc__']}\n{function.partition('>>> ')[0]}"

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        return importlib.import_module("foggy_synscapes.api").fog(*arguments, **options)


sys.modules[__name__].__class__ = _Callable
