"""The stand-in of Foggy Driving."""

from dataclasses import replace
from functools import reduce
from typing import Any

import numpy as np

from foggy_synscapes.datasets import foggy_driving
from foggy_synscapes.schema import Section, setting
from foggy_synscapes.standin import fog
from foggy_synscapes.standin.layouts.layout import Files, Frame, StandIn, lines
from foggy_synscapes.standin.render import Scene

FINE, COARSE = 11, 12
"""Streams of random numbers."""

BETAS = (0.008, 0.013, 0.017, 0.026, 0.045)
"""1/m, none of them a training beta (0.005, 0.01, 0.02, 0.03, 0.06)."""

DENSE = 0.04
"""1/m from which a frame counts as densely foggy: about one of five, as in the real set (21 of 101)."""

SIZES = ((1.0, 1.0), (1.25, 0.9), (1.1, 1.05), (1.32, 0.88), (1.0, 0.92))
"""Sizes of frames as shares of the stand-in's rows and columns: phones and the web differ."""

SOURCES = ("public", "pedestrian", "web")


class DrivingCounts(Section):
    """Frames rendered with fine and with coarse labels."""

    inline = True

    fine: int = setting("with fine labels", unit="frames", ge=1)
    coarse: int = setting("with coarse labels", unit="frames", ge=1)


def photograph(seed: int, size: tuple[int, int], coarse: bool, number: int) -> Scene:
    """Frame `number` (from 0) of the coarsely or finely annotated part; its size varies about `size`."""
    key = (seed, COARSE if coarse else FINE, number)
    shares = SIZES[np.random.default_rng((*key, 2)).integers(len(SIZES))]
    rows, columns = (round(length * share) for length, share in zip(size, shares, strict=True))
    shot = fog.photograph(key, (rows, columns), BETAS[number % len(BETAS)], trains=True)
    return replace(shot, label_ids=coarsen(shot.label_ids)) if coarse else shot


def coarsen(label_ids: np.ndarray) -> np.ndarray:
    """Coarse labels, uint8 (H, W): blobs well inside each region, unlabelled (0) borders and small things.

    The border is about one pixel in a hundred of the image's width.
    """
    radius = max(2, label_ids.shape[1] // 128)
    core = np.where(_around(label_ids, radius, np.minimum) == _around(label_ids, radius, np.maximum), label_ids, 0)
    # Grown back part of the way, where only one label is near: edges get the straightness of polygons.
    highest = _around(core, radius - 1, np.maximum)
    lowest = _around(np.where(core == 0, 255, core), radius - 1, np.minimum)
    return np.where(highest == lowest, highest, 0).astype(np.uint8)


def _around(values: np.ndarray, radius: int, choose: np.ufunc) -> np.ndarray:
    # The least or greatest value of the square around each pixel: along the columns, then along the rows.
    for _ in range(2):
        padded = np.pad(values, ((radius, radius), (0, 0)), mode="edge")
        values = reduce(choose, [padded[k : k + len(values)] for k in range(2 * radius + 1)]).T
    return values


def _render(seed: int, size: tuple[int, int], coarse: bool, number: int) -> list[Any]:
    shot = photograph(seed, size, coarse, number)
    return [shot.rgb, shot.label_ids] + ([] if coarse else [shot.instance_ids()])


def _frames(plan: Any) -> list[Frame]:
    found = []
    for coarse, count in ((False, plan.foggy_driving.fine), (True, plan.foggy_driving.coarse)):
        for number in range(count):
            source = SOURCES[number % len(SOURCES)]
            name = f"{source}/{source}_20190{2 if coarse else 1}01_{number:06d}"
            labels = foggy_driving.labels(name, coarse)
            instances = [] if coarse else [labels.replace("_labelIds", "_instanceIds")]
            paths = [foggy_driving.image(name, coarse), labels, *instances]
            found.append(Frame(paths, _render, (plan.seed, plan.size, coarse, number)))
    return found


def _lists(frames: list[Frame], scenes: Any) -> Files:
    # With the names and line form of the real ones; the finely annotated frames come first.
    counts = scenes.stand_in.foggy_driving
    numbers = [*range(counts.fine), *range(counts.coarse)]
    dense = [frame for frame, k in zip(frames, numbers, strict=True) if BETAS[k % len(BETAS)] >= DENSE]
    folder = "lists_file_names"
    return [
        lines(foggy_driving.LABELS, (frame.paths[1] for frame in frames)),
        lines(f"{folder}/gt_testdense_filenames.txt", (frame.paths[1] for frame in dense)),
        lines(foggy_driving.IMAGES, (frame.paths[0] for frame in frames)),
        lines(f"{folder}/leftImg8bit_testdense_filenames.txt", (frame.paths[0] for frame in dense)),
        lines(f"{folder}/leftImg8bit_testfine_filenames.txt", (frame.paths[0] for frame in frames[: counts.fine])),
    ]


STAND_IN = StandIn(
    counts=DrivingCounts,
    text="with fine and with coarse labels",
    published="33 and 68",
    frames=_frames,
    lists=_lists,
    tests=lambda scenes: scenes.stand_in.foggy_driving.fine + scenes.stand_in.foggy_driving.coarse,
)
