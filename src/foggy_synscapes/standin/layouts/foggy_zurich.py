"""The stand-in of Foggy Zurich."""

from typing import Any

from foggy_synscapes.datasets import foggy_zurich
from foggy_synscapes.labels import to_train_ids
from foggy_synscapes.schema import Count
from foggy_synscapes.standin import fog
from foggy_synscapes.standin.layouts.layout import Files, Frame, StandIn, lines
from foggy_synscapes.standin.render import Scene

STREAM = 13
"""Of random numbers."""

BETAS = (0.007, 0.012, 0.016, 0.024, 0.036)
"""1/m, none of them a training beta (0.005, 0.01, 0.02, 0.03, 0.06)."""

SEQUENCES = ("GP010229", "GP020397")
"""Drives of Foggy Zurich."""


def photograph(seed: int, size: tuple[int, int], number: int) -> Scene:
    """Frame `number` (from 0), as wide as `size`, 16 : 9 and without trains."""
    rows, columns = round(size[1] * 9 / 16), size[1]
    return fog.photograph((seed, STREAM, number), (rows, columns), BETAS[number % len(BETAS)], trains=False)


def _render(seed: int, size: tuple[int, int], number: int) -> list[Any]:
    shot = photograph(seed, size, number)
    return [shot.rgb, shot.label_ids, to_train_ids(shot.label_ids, f"frame {number}")]


def _frames(plan: Any) -> list[Frame]:
    found = []
    for number in range(plan.foggy_zurich):
        place, sequence = divmod(number, len(SEQUENCES))
        name = f"{SEQUENCES[sequence]}/{1508040913 + number}.0_frame_{place * 15 + 10:06d}"
        paths = [kind(name) for kind in (foggy_zurich.image, foggy_zurich.labels, foggy_zurich.train_labels)]
        found.append(Frame(paths, _render, (plan.seed, plan.size, number)))
    return found


def _lists(frames: list[Frame], _scenes: Any) -> Files:
    # Six; testv1 names two of five frames, as 16 of 40 in the real set.
    found = []
    for version in ("testv1", "testv2"):
        part = frames[: _tested(len(frames), version)]
        for k, kind in enumerate(("RGB", "gt_labelIds", "gt_labelTrainIds")):
            found.append(lines(foggy_zurich.list_path(kind, version), (frame.paths[k] for frame in part)))
    return found


def _tested(drawn: int, version: str) -> int:
    return drawn if version == "testv2" else max(1, drawn * 2 // 5)


STAND_IN = StandIn(
    counts=Count,
    text="of the whole dataset",
    published="40",
    frames=_frames,
    lists=_lists,
    tests=lambda scenes: _tested(scenes.stand_in.foggy_zurich, scenes.zurich_list),
)
