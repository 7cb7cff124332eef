"""The stand-in of Cityscapes."""

from typing import Any

import numpy as np

from foggy_synscapes.datasets import cityscapes
from foggy_synscapes.schema import Section, setting
from foggy_synscapes.standin import stereo
from foggy_synscapes.standin.layouts.layout import Frame, StandIn
from foggy_synscapes.standin.render import Scene, render
from foggy_synscapes.standin.style import is_blue

CITIES = {"train": ("aachen", "bochum"), "val": ("frankfurt", "lindau")}
"""Cities of the stand-in's splits; real ones of the same splits."""

STREAMS = {"train": 2, "val": 3}
"""Streams of random numbers."""


class CityscapesCounts(Section):
    """Frames rendered for a layout with training and validation splits."""

    inline = True

    train: int = setting("of the training split", unit="frames", ge=1)
    val: int = setting("of the validation split", unit="frames", ge=1)


def name(plan: Any, split: str, number: int) -> str:
    """Split, city and stem of frame `number` (from 0) of a split."""
    cities = CITIES[split]
    of_a_city = -(-getattr(plan.cityscapes, split) // len(cities))
    city, sequence = cities[number // of_a_city], number % of_a_city
    return f"{split}/{city}/{city}_{sequence:06d}_000019"


def scene(seed: int, size: tuple[int, int], split: str, number: int) -> tuple[Scene, np.ndarray]:
    """Frame `number` (from 0) of a split, of `size` rows and columns, and its measured disparity, uint16 (H, W)."""
    stream = seed, STREAMS[split]
    shown = render((*stream, number), size, real=True, blue=is_blue(stream, number), hood=True)
    return shown, stereo.measure(shown, np.random.default_rng((*stream, number, 1)))


def render_frame(seed: int, size: tuple[int, int], split: str, number: int) -> list[Any]:
    """Image, labelIds, instance ids, disparity and camera of a frame."""
    shown, disparity = scene(seed, size, split, number)
    camera = shown.rig.metadata()
    camera["extrinsic"]["baseline"] = stereo.BASELINE
    del camera["intrinsic"]["resx"], camera["intrinsic"]["resy"]
    return [shown.rgb, shown.label_ids, shown.instance_ids(), disparity, camera]


def _frames(plan: Any) -> list[Frame]:
    kinds = cityscapes.image, cityscapes.labels, cityscapes.instances, cityscapes.disparity, cityscapes.camera
    found = []
    for split in CITIES:
        for number in range(getattr(plan.cityscapes, split)):
            paths = [kind(name(plan, split, number)) for kind in kinds]
            found.append(Frame(paths, render_frame, (plan.seed, plan.size, split, number)))
    return found


STAND_IN = StandIn(
    counts=CityscapesCounts,
    text="of each split",
    published="2,975 and 500",
    frames=_frames,
    tests=lambda scenes: scenes.stand_in.cityscapes.val,
)
