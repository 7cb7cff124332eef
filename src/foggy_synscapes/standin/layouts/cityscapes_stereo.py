"""The stand-in of Cityscapes' stereo part: frames as refined ones are chosen, with a right view."""

from typing import Any

import numpy as np

from foggy_synscapes.datasets import cityscapes_stereo
from foggy_synscapes.standin import right_view
from foggy_synscapes.standin.layouts import cityscapes
from foggy_synscapes.standin.layouts.foggy_cityscapes import refined
from foggy_synscapes.standin.layouts.layout import Frame, StandIn


def _render(seed: int, size: tuple[int, int], split: str, number: int) -> list[Any]:
    # The frame of Cityscapes, made again from its seed.
    shown, _ = cityscapes.scene(seed, size, split, number)
    right = right_view.draw(shown, np.random.default_rng((seed, cityscapes.STREAMS[split], number, 2)))
    left, _, instances, disparity, camera = cityscapes.render_frame(seed, size, split, number)
    return [left, right, disparity, camera, instances]


def _frames(plan: Any) -> list[Frame]:
    return [
        Frame(cityscapes_stereo.paths(cityscapes.name(plan, *clear)), _render, (plan.seed, plan.size, *clear))
        for clear in refined(plan, plan.cityscapes_stereo)
    ]


def _check(plan: Any) -> None:
    for split in cityscapes.STREAMS:
        asked, count = getattr(plan.cityscapes_stereo, split), getattr(plan.cityscapes, split)
        if asked > count:
            raise ValueError(f"cityscapes_stereo.{split}: {asked} frames of only {count} Cityscapes frames")


STAND_IN = StandIn(
    counts=cityscapes.CityscapesCounts,
    text="of each split with a right view, the refined ones",
    published="498 and 52, or all 2,975 and 500",
    frames=_frames,
    others=("cityscapes",),
    check=_check,
)
