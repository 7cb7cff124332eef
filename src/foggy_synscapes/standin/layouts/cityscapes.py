"""The stand-in of Cityscapes."""

from dataclasses import dataclass
from typing import Any

from foggy_synscapes.datasets import cityscapes
from foggy_synscapes.schema import Section, setting
from foggy_synscapes.standin import annotate, frames, stereo
from foggy_synscapes.standin.layouts.layout import Files, StandIn

CITIES = {"train": ("aachen", "bochum"), "val": ("frankfurt", "lindau")}
"""Cities of the stand-in's splits; real ones of the same splits."""

STREAMS = {"train": frames.CITYSCAPES_TRAIN, "val": frames.CITYSCAPES_VAL}


class CityscapesCounts(Section):
    """Frames rendered for a layout with training and validation splits."""

    inline = True

    train: int = setting("of the training split", unit="frames", ge=1)
    val: int = setting("of the validation split", unit="frames", ge=1)


@dataclass(frozen=True)
class CityscapesFrame:
    """Frame `number` (from 0) of a split of Cityscapes with `count` frames."""

    seed: int
    size: tuple[int, int]
    split: str
    number: int
    count: int

    def name(self) -> str:
        """Split, city and stem."""
        cities = CITIES[self.split]
        first = -(-self.count // len(cities))
        city, sequence = cities[self.number // first], self.number % first
        return f"{self.split}/{city}/{city}_{sequence:06d}_000019"

    def paths(self) -> list[str]:
        """Files of the frame below the root."""
        kinds = (cityscapes.image, cityscapes.labels, cityscapes.instances, cityscapes.disparity, cityscapes.camera)
        return [kind(self.name()) for kind in kinds]

    def files(self) -> Files:
        """Render the frame."""
        scene, disparity = frames.cityscapes(self.seed, STREAMS[self.split], self.number, self.size)
        intrinsic = {name: value for name, value in scene.rig.intrinsic().items() if name not in ("resx", "resy")}
        camera = {"extrinsic": {"baseline": stereo.BASELINE, **scene.rig.extrinsic()}, "intrinsic": intrinsic}
        instances = annotate.instance_ids(scene.label_ids, scene.instances)
        return list(zip(self.paths(), (scene.rgb, scene.label_ids, instances, disparity, camera), strict=True))


def frame(plan: Any, split: str, number: int) -> CityscapesFrame:
    """One frame of a split."""
    return CityscapesFrame(plan.seed, plan.size, split, number, getattr(plan.cityscapes, split))


def frames_of(plan: Any) -> list[CityscapesFrame]:
    """All frames of both splits."""
    return [frame(plan, split, k) for split in CITIES for k in range(getattr(plan.cityscapes, split))]


STAND_IN = StandIn(counts=CityscapesCounts, text="of each split", published="2,975 and 500", frames=frames_of)
