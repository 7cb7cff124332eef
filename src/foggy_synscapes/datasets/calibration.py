"""A few images of a training list, to find the ranges of numbers that a network meets."""

from pathlib import Path

import numpy as np

from foggy_synscapes.datasets.pairs import Composite
from foggy_synscapes.datasets.uris import RECIPE, Reader
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.images import read_rgb
from foggy_synscapes.io.tables import read_csv


def calibration_images(path: Path, reader: Reader, count: int, composite: Composite) -> list[np.ndarray]:
    """So many images of a list of `subset`, spread evenly over it, or all where it has fewer; uint8 (H, W, 3).

    composite : makes the images of which the list names recipes

    Raises FoggyError if the list is empty or cannot be read, or an image is missing, damaged or not as listed.
    """
    rows = read_csv(path, ("image", "image_sha256"))
    if not rows:
        raise FoggyError(f"{path}: lists no image")
    count = min(count, len(rows))
    chosen = [rows[number * len(rows) // count] for number in range(count)]
    images = []
    for row in chosen:
        data = reader.read(row["image"], row["image_sha256"])
        made = row["image"].endswith(RECIPE)
        images.append(composite(data, reader.read, row["image"]) if made else read_rgb(data, row["image"]))
    return images
