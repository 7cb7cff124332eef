"""The frames of each stand-in dataset as arrays, each decided by the seed, the dataset's stream and its number."""

from dataclasses import dataclass

import numpy as np

from foggy_synscapes.standin import annotate, stereo
from foggy_synscapes.standin import fog as haze
from foggy_synscapes.standin.render import Scene, render
from foggy_synscapes.standin.sky import is_blue

SYNSCAPES, CITYSCAPES_TRAIN, CITYSCAPES_VAL, DRIVING_FINE, DRIVING_COARSE, ZURICH = 1, 2, 3, 11, 12, 13
"""Streams of random numbers: no frame of one shares a scene with a frame of another."""

SIZES = ((1.0, 1.0), (1.25, 0.9), (1.1, 1.05), (1.32, 0.88), (1.0, 0.92))
"""Sizes of Foggy Driving frames as shares of the stand-in's rows and columns: phones and the web differ."""


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


def foggy_driving(seed: int, frame: int, size: tuple[int, int], coarse: bool) -> Photograph:
    """Frame `frame` (from 0) of the finely or coarsely annotated part; its size varies from frame to frame."""
    key = (seed, DRIVING_COARSE if coarse else DRIVING_FINE, frame)
    rows, columns = SIZES[int(np.random.default_rng((*key, 2)).integers(len(SIZES)))]
    own = max(16, round(size[0] * rows)), max(16, round(size[1] * columns))
    shot = _photograph(key, own, haze.DRIVING_BETAS[frame % len(haze.DRIVING_BETAS)], trains=True)
    labels = annotate.coarsen(shot.label_ids) if coarse else shot.label_ids
    return Photograph(shot.rgb, labels, shot.instances, shot.beta)


def foggy_zurich(seed: int, frame: int, size: tuple[int, int]) -> Photograph:
    """Frame `frame` (from 0), 16 : 9 and without trains."""
    own = max(16, round(size[1] * 9 / 16)), size[1]
    return _photograph((seed, ZURICH, frame), own, haze.ZURICH_BETAS[frame % len(haze.ZURICH_BETAS)], trains=False)


def _photograph(key: tuple[int, ...], size: tuple[int, int], beta: float, trains: bool) -> Photograph:
    scene = render(key, size, "real", overcast=True, trains=trains)
    rgb = haze.photograph(scene, beta, np.random.default_rng((*key, 1)))
    return Photograph(rgb, scene.label_ids, scene.instances, beta)
