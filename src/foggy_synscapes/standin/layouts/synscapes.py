"""The stand-in of Synscapes."""

from typing import Any

import numpy as np

from foggy_synscapes.datasets import synscapes
from foggy_synscapes.schema import Count
from foggy_synscapes.standin.layouts.layout import Frame, StandIn
from foggy_synscapes.standin.render import Scene, render
from foggy_synscapes.standin.style import is_blue

STREAM = 1
"""Of random numbers: no frame of one stream shares a scene with a frame of another."""


def scene(seed: int, size: tuple[int, int], number: int) -> Scene:
    """Frame `number` (from 0), of `size` rows and columns."""
    return render((seed, STREAM, number), size, real=False, blue=is_blue((seed, STREAM), number))


def instance_colours(instances: np.ndarray) -> np.ndarray:
    """Instance numbers uint32 (H, W) as uint8 (H, W, 3): number = R + 256 G + 65536 B.

    >>> instance_colours(np.array([[240001]], dtype=np.uint32)).tolist()
    [[[129, 169, 3]]]
    """
    return np.stack([(instances >> shift) & 255 for shift in (0, 8, 16)], axis=-1).astype(np.uint8)


def _render(seed: int, size: tuple[int, int], number: int) -> list[Any]:
    shown = scene(seed, size, number)
    meta = {"camera": shown.rig.metadata(), "instance": shown.instance, "scene": shown.scene}
    return [shown.rgb, shown.depth, shown.label_ids, instance_colours(shown.instances), meta]


def _frames(plan: Any) -> list[Frame]:
    kinds = synscapes.rgb, synscapes.depth, synscapes.class_, synscapes.instance, synscapes.meta
    return [
        Frame([kind(number + 1) for kind in kinds], _render, (plan.seed, plan.size, number))
        for number in range(plan.synscapes)
    ]


STAND_IN = StandIn(counts=Count, text="of the whole dataset", published="25,000", frames=_frames)
