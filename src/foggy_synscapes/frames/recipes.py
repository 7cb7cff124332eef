"""Foggy images composited when they are read: a recipe in place of each rendered image.

A recipe names the clear image, its depth, the atmospheric light and beta, and the SHA-256 of the pixels that came out
when it was written. Who composites it gets exactly these pixels or an error, also after the code of fog has changed.
"""

import json
from collections.abc import Callable
from typing import Any

import numpy as np

from foggy_synscapes.camera import Camera
from foggy_synscapes.datasets import synscapes, uris
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.fog.airlight import Airlight
from foggy_synscapes.fog.optics import foggy_images
from foggy_synscapes.frames import rendering
from foggy_synscapes.io.hashing import sha256_bytes

KEYS = ("airlight", "beta", "camera", "geometry", "inputs", "pixels")


def write(
    clear: rendering.Clear, camera: Camera, geometry: str, light: Airlight, beta: str, frame: int, index: dict[str, str]
) -> bytes:
    """Recipe of a frame at one beta in 1/m; `index` holds the SHA-256 of the dataset's files by path."""
    recipe = {
        "airlight": light.levels,
        "beta": beta,
        "camera": vars(camera),
        "geometry": geometry,
        "inputs": [
            (uris.of_dataset("synscapes", path), index[path]) for path in (synscapes.rgb(frame), synscapes.depth(frame))
        ],
    }
    pixels = _composite(clear, recipe)
    return json.dumps({**recipe, "pixels": sha256_bytes(pixels)}, sort_keys=True, indent=1).encode()


def composite(data: bytes, read: Callable[[str, str], bytes], called: str) -> np.ndarray:
    """The foggy image of a recipe: uint8 (H, W, 3), equal to the rendered one.

    Parameters
    ----------
    data : the recipe
    read : gives the bytes behind a URI, checked against a SHA-256
    called : what errors call the recipe

    Raises FoggyError if it is no recipe, its frame cannot be read, or other pixels come out than when it was written.
    """
    recipe = _parse(data, called)
    (rgb, rgb_sha256), (depth, depth_sha256) = recipe["inputs"]
    clear = rendering.read_clear(read(rgb, rgb_sha256), read(depth, depth_sha256), rgb, depth)
    pixels = _composite(clear, recipe)
    if sha256_bytes(pixels) != recipe["pixels"]:
        raise FoggyError(
            f"{called}: other pixels come out than when the recipe was written. Has the code of fog changed? "
            "Then make the shard again by `foggy fog`, and what follows from it."
        )
    return pixels


def _composite(clear: rendering.Clear, recipe: dict[str, Any]) -> np.ndarray:
    rays = rendering.rays_of(clear, Camera(**recipe["camera"]), "the recipe", recipe["geometry"])
    return foggy_images(clear.image, clear.depth, rays, recipe["airlight"], [float(recipe["beta"])])[0]


def _parse(data: bytes, called: str) -> dict[str, Any]:
    try:
        recipe = json.loads(data)
        if sorted(recipe) != sorted(KEYS) or [len(entry) for entry in recipe["inputs"]] != [2, 2]:
            raise ValueError(f"expected {', '.join(KEYS)}")
    except (ValueError, TypeError) as error:
        raise FoggyError(f"{called}: no recipe of a foggy image: {error}. Make the shard again.") from error
    return recipe
