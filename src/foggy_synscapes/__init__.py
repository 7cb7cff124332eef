"""Foggy Synscapes: fog on street scenes by their depth, scores of segmentation, and the experiment on synthetic data.

>>> import numpy as np
>>> from foggy_synscapes import Camera, fog
>>> image, depth = np.full((2, 3, 3), 100, np.uint8), np.full((2, 3), 50.0)
>>> camera = Camera(fx=100, fy=100, u0=1.5, v0=1.0, resx=3, resy=2)
>>> fog(image, depth, beta=0.02, camera=camera, airlight=(200, 200, 200))[0, 0].tolist()
[163, 163, 163]

Nothing is imported before it is asked for: reading the package takes no time, and scores need no compiler.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from foggy_synscapes.api import (
        Airlight,
        Camera,
        FoggyError,
        airlight,
        attenuation,
        complete,
        distance,
        fog,
        read_camera,
        read_depth,
        read_image,
        score,
        transmittance,
        visibility,
    )

__version__ = "0.1.0"
__all__ = [
    "Airlight",
    "Camera",
    "FoggyError",
    "airlight",
    "attenuation",
    "complete",
    "distance",
    "fog",
    "read_camera",
    "read_depth",
    "read_image",
    "score",
    "transmittance",
    "visibility",
]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    import importlib

    # `fog` is a package too, which can be called: it takes this name as soon as one of its parts is imported.
    if name == "fog":
        return importlib.import_module("foggy_synscapes.fog")
    return getattr(importlib.import_module("foggy_synscapes.api"), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
