"""Foggy images composited when they are read, from recipes: see `frames.recipes`."""

from collections.abc import Callable

import numpy as np

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.frames import rendering
from foggy_synscapes.frames.recipes import KEYS, pixels_of
from foggy_synscapes.io.files import named, parse_json
from foggy_synscapes.io.hashing import sha256_bytes


def composite(data: bytes, read: Callable[[str, str], bytes], called: str) -> np.ndarray:
    """The foggy image of a recipe: uint8 (H, W, 3), equal to the rendered one.

    Parameters
    ----------
    data : the recipe
    read : gives the bytes behind a URI, checked against a SHA-256
    called : what errors call the recipe

    Raises FoggyError if it is no recipe, its frame cannot be read, or other pixels come out than when it was written.
    """
    advice = "Make the shard again."
    recipe = parse_json(data, called, "recipe of a foggy image", advice)
    with named(called, "recipe of a foggy image", advice):
        if sorted(recipe) != sorted(KEYS) or [len(entry) for entry in recipe["inputs"]] != [2, 2]:
            raise ValueError(f"expected {', '.join(KEYS)}")
        (rgb, rgb_sha256), (depth, depth_sha256) = recipe["inputs"]
        clear = rendering.read_clear(read(rgb, rgb_sha256), read(depth, depth_sha256), rgb, depth)
        try:
            pixels = pixels_of(clear, recipe)
        except FoggyError as error:
            raise FoggyError(f"{called}: {error}") from error
    if sha256_bytes(pixels.data) != recipe["pixels"]:
        raise FoggyError(
            f"{called}: other pixels come out than when the recipe was written. Has the code of fog changed? "
            "Then make the shard again by `foggy fog`, and what follows from it."
        )
    return pixels
