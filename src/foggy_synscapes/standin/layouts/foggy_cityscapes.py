"""The stand-in of Foggy Cityscapes: fog on the refined ones of the frames of Cityscapes' stand-in."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from foggy_synscapes.datasets import foggy_cityscapes
from foggy_synscapes.standin import fog, frames
from foggy_synscapes.standin.layouts.cityscapes import CITIES, STREAMS, CityscapesCounts, CityscapesFrame, frame
from foggy_synscapes.standin.layouts.layout import Files, StandIn, lines


@dataclass(frozen=True)
class FoggyCityscapesFrame:
    """A refined frame of Foggy Cityscapes, made again from the seed of its clear frame."""

    clear: CityscapesFrame

    def paths(self) -> list[str]:
        """Files of the frame below the root."""
        return [foggy_cityscapes.image(self.clear.name(), beta) for beta in foggy_cityscapes.BETAS]

    def files(self) -> Files:
        """Render the frame."""
        clear = self.clear
        scene, disparity = frames.cityscapes(clear.seed, STREAMS[clear.split], clear.number, clear.size)
        foggy = fog.from_stereo(scene, disparity, [float(beta) for beta in foggy_cityscapes.BETAS])
        return list(zip(self.paths(), foggy, strict=True))


def frames_of(plan: Any) -> list[FoggyCityscapesFrame]:
    """The refined frames of both splits; ValueError if there are not as many."""
    chosen = []
    for split in CITIES:
        count, asked = getattr(plan.cityscapes, split), getattr(plan.foggy_cityscapes, split)
        try:
            refined = frames.refined(plan.seed, STREAMS[split], count, asked)
        except ValueError as error:
            raise ValueError(f"{error}; ask for fewer") from error
        chosen += [FoggyCityscapesFrame(frame(plan, split, number)) for number in refined]
    return chosen


def refined_list(chosen: Sequence[FoggyCityscapesFrame], scenes: Any) -> Files:
    """The list of refined frames, at the path that the params name."""
    return [lines(scenes.refined_list, (frame.clear.name() for frame in chosen))]


def refined_are_cityscapes(plan: Any) -> None:
    """Raise ValueError where more frames are refined than there are."""
    for split in CITIES:
        refined, count = getattr(plan.foggy_cityscapes, split), getattr(plan.cityscapes, split)
        if refined > count:
            raise ValueError(f"foggy_cityscapes.{split}: {refined} refined frames of only {count} Cityscapes frames")


STAND_IN = StandIn(
    counts=CityscapesCounts,
    text="refined ones of each split",
    published="498 and 52",
    frames=frames_of,
    lists=refined_list,
    others=("cityscapes",),
    check=refined_are_cityscapes,
)
