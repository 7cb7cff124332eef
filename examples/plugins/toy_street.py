"""A test set: toy streets, a layout of two folders, `images/NAME.png` and `labels/NAME.png` (labelIds).

This file's name is the dataset's name. `DATASET` says which files belong to it; `STAND_IN` draws it where its root in
the params is `stand-in`. A dataset without a stand-in leaves the second part out.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from foggy_synscapes.datasets.dataset import Dataset
from foggy_synscapes.schema import Count
from foggy_synscapes.standin.layouts.layout import Frame, StandIn


def label(image: str) -> str:
    """Path of the label map of an image."""
    return image.replace("images/", "labels/")


def files(root: Path, _scenes: Any, _part: str) -> list[str]:
    """All images and their label maps; `foggy scenes` refuses a list with a file that is missing."""
    images = [path.relative_to(root).as_posix() for path in root.glob("images/*.png")]
    return [*images, *map(label, images)]


def tested(_root: Path, index: Mapping[str, str], _scenes: Any) -> list[tuple[str, str]]:
    """Every image, with its label map."""
    return [(path, label(path)) for path in sorted(index) if path.startswith("images/")]


DATASET = Dataset(title="Toy Street", short_title="Toy Street", files=files, test_pairs=tested)

SKY, ROAD, CAR = 23, 7, 26
"""labelIds of Cityscapes."""


def render(seed: int, size: tuple[int, int], number: int) -> tuple[np.ndarray, np.ndarray]:
    """A grey sky over a darker road, with a red car somewhere on it, and its labelIds."""
    (height, width), random = size, np.random.default_rng((seed, number))
    ids = np.full(size, SKY, np.uint8)
    ids[height // 2 :] = ROAD
    left = int(random.integers(0, width * 3 // 4))
    ids[height // 2 : height * 3 // 4, left : left + width // 4] = CAR
    rgb = np.zeros((*size, 3), np.uint8)
    for labelled, colour in ((SKY, (200, 200, 205)), (ROAD, (90, 90, 90)), (CAR, (150, 40, 40))):
        rgb[ids == labelled] = colour
    return rgb, ids


def frames(plan: Any) -> list[Frame]:
    """As many frames as `scenes.stand_in.toy_street` says; the plan is the params section `scenes.stand_in`."""
    images = [f"images/{number:03d}.png" for number in range(plan.toy_street)]
    return [Frame([path, label(path)], render, (plan.seed, plan.size, k)) for k, path in enumerate(images)]


STAND_IN = StandIn(counts=Count, text="of the toy test set", published="none", frames=frames)
