"""Foggy images composited when they are read: a recipe in place of each rendered image.

A recipe names the clear image, its depth, the airlight and beta, and the SHA-256 of the pixels that came out
when it was written. Who composites it gets exactly these pixels or an error, also after the code of fog has changed.
"""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from foggy_synscapes.camera import Camera
from foggy_synscapes.datasets import synscapes, uris
from foggy_synscapes.fog.airlight import Airlight
from foggy_synscapes.fog.models import chosen
from foggy_synscapes.frames import rendering
from foggy_synscapes.io.hashing import sha256_bytes
from foggy_synscapes.params import Fog

KEYS = ("airlight", "beta", "camera", "geometry", "inputs", "model", "pixels")


def write(
    clear: rendering.Clear,
    camera: Camera,
    fog: Fog,
    light: Airlight,
    beta: str,
    frame: int,
    index: Mapping[str, str],
    model: str = "",
) -> bytes:
    """Recipe of a frame at one beta in 1/m, by the model and the geometry of the params section fog.

    index : SHA-256 of the dataset's files by path; model : in place of the section's
    """
    recipe = {
        "airlight": light.levels,
        "beta": beta,
        "camera": vars(camera),
        "geometry": fog.geometry,
        "inputs": [
            (uris.of_dataset("synscapes", path), index[path]) for path in (synscapes.rgb(frame), synscapes.depth(frame))
        ],
        "model": model or fog.spelt(),
    }
    pixels = pixels_of(clear, recipe)
    return json.dumps({**recipe, "pixels": sha256_bytes(pixels.data)}, sort_keys=True, indent=1).encode()


def pixels_of(clear: rendering.Clear, recipe: dict[str, Any]) -> np.ndarray:
    """The foggy image that a recipe describes: uint8 (H, W, 3)."""
    rays = rendering.rays_of(clear, Camera(**recipe["camera"]), "the recipe", recipe["geometry"])
    frame = clear.image, clear.depth, rays, recipe["airlight"], [float(recipe["beta"])]
    return chosen(recipe["model"]).images(*frame)[0]
