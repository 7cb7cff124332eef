"""Frames of the stand-in as arrays, each decided by the seed, its dataset's stream and its number."""

from dataclasses import dataclass

import numpy as np

from foggy_synscapes.standin import fog, stereo
from foggy_synscapes.standin.render import Scene, render
from foggy_synscapes.standin.style import is_blue

SYNSCAPES, CITYSCAPES_TRAIN, CITYSCAPES_VAL = 1, 2, 3
"""Streams of random numbers: no frame of one shares a scene with a frame of another. Each test set has its own."""


@dataclass(frozen=True)
class Photograph:
    """A test frame: foggy rgb uint8 (H, W, 3), label_ids uint8 (H, W), instances uint32 (H, W), beta in 1/m."""

    rgb: np.ndarray
    label_ids: np.ndarray
    instances: np.ndarray
    beta: float


def synscapes(seed: int, frame: int, size: tuple[int, int]) -> Scene:
    """Frame `frame` (from 0) of the purely synthetic data."""
    stream = (seed, SYNSCAPES)
    return render((*stream, frame), size, "synthetic", blue=is_blue(stream, frame))


def cityscapes(seed: int, stream: int, frame: int, size: tuple[int, int]) -> tuple[Scene, np.ndarray]:
    """Frame `frame` (from 0) of the training or validation stream, and its measured disparity, uint16 (H, W)."""
    key = (seed, stream)
    scene = render((*key, frame), size, "real", blue=is_blue(key, frame), hood=True, spread=0.1)
    return scene, stereo.measure(scene, np.random.default_rng((*key, frame, 1)))


def refined(seed: int, stream: int, frames: int, count: int) -> list[int]:
    """Which frames are refined: `count` of those without a blue sky, spread evenly.

    Raises ValueError if there are fewer.
    """
    fitting = [frame for frame in range(frames) if not is_blue((seed, stream), frame)]
    if count > len(fitting):
        raise ValueError(f"count: {count} refined frames of {len(fitting)} without a blue sky")
    return [fitting[k * len(fitting) // count] for k in range(count)]


def photograph(key: tuple[int, ...], size: tuple[int, int], beta: float, trains: bool) -> Photograph:
    """A test frame of (seed, stream, number), in fog of beta in 1/m; `trains`: whether there may be any."""
    scene = render(key, size, "real", overcast=True, trains=trains)
    rgb = fog.photograph(scene, beta, np.random.default_rng((*key, 1)))
    return Photograph(rgb, scene.label_ids, scene.instances, beta)
