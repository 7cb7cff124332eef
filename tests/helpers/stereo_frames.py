"""Small stereo frames in the layout of Cityscapes: a street of patches, drawn for both cameras, with measured holes."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from foggy_synscapes.datasets import cityscapes
from foggy_synscapes.io.atomic import write_bytes, write_text
from foggy_synscapes.io.images import encode_png

SIZE = (200, 320)
"""Rows and columns: 31 pixels for each of the published 2,048 superpixels, which need 20 for a plane."""

NAMES = ("train/aachen/aachen_000000_000019", "train/aachen/aachen_000001_000019", "val/lindau/lindau_000000_000019")
BASELINE, FX = 0.22, 350.0
SKY, ROAD, WALL, OUT_OF_ROI = 23, 7, 11, 3


def camera(**changes: Any) -> dict[str, Any]:
    """A camera file's content; `changes` of the extrinsic part, None to leave a key out."""
    extrinsic = {"baseline": BASELINE, "x": 1.7, "y": -0.1, "z": 1.2} | changes
    return {
        "extrinsic": {key: value for key, value in extrinsic.items() if value is not None},
        "intrinsic": {"fx": FX, "fy": FX, "u0": 161.0, "v0": 99.0},
    }


def content(seed: int, size: tuple[int, int] = SIZE) -> dict[str, np.ndarray]:
    """Left, right, stored disparity and instance ids of a frame; larger ones are as much more finely sampled."""
    rng = np.random.default_rng(seed)
    rows, columns = size
    y, x = np.mgrid[:rows, :columns]
    finer = rows // SIZE[0]
    y, x = y // finer, x // finer
    ids = np.where(y < 60, SKY, np.where(y < 110, WALL, ROAD)).astype(np.uint16)
    car = (y >= 70) & (y < 120) & (x >= 100) & (x < 140)
    ids[car] = 26001
    depth = np.where(y < 60, np.inf, np.where(y < 110, 25 + 0.05 * x, 1.3 * FX / np.maximum(y - 90, 1)))
    depth[car] = 9.0
    ids[-6:] = OUT_OF_ROI
    d = BASELINE * FX / depth
    patches = rng.integers(40, 200, (rows // 8, columns // 8, 3)).repeat(8, axis=0).repeat(8, axis=1)
    left = np.where((y < 60)[..., None], (225, 235, 240), patches).astype(np.uint8)
    right = left.copy()
    for row in range(rows):
        for column in np.argsort(d[row]):  # from far to near
            to = int(np.floor(column - d[row, column] + 0.5))
            if 0 <= to < columns:
                right[row, to] = left[row, column]
    stored = np.floor(d * 256 + 1.5 + rng.normal(0, 8, size)).clip(1, 65535).astype(np.uint16)
    stored[rng.random(size) < 0.02] = 0
    stored[(y >= 120) & (y < 135) & (x >= 40) & (x < 70)] = 0
    return {"left": left, "right": right, "disparity": stored, "ids": ids}


def write(root: Path, name: str, arrays: dict[str, np.ndarray], about: dict[str, Any] | None = None) -> None:
    """Write a frame where Cityscapes has it."""
    paths = {
        "left": cityscapes.image(name),
        "right": cityscapes.right(name),
        "disparity": cityscapes.disparity(name),
        "ids": cityscapes.instances(name),
    }
    for key, pixels in arrays.items():
        write_bytes(root / paths[key], encode_png(pixels))
    write_text(root / cityscapes.camera(name), json.dumps(camera() if about is None else about))


def write_all(root: Path) -> Path:
    """Three frames of two splits."""
    for seed, name in enumerate(NAMES):
        write(root, name, content(seed))
    return root
