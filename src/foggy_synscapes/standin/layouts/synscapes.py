"""The stand-in of Synscapes."""

from dataclasses import dataclass
from typing import Any

from foggy_synscapes.datasets import synscapes
from foggy_synscapes.schema import Count
from foggy_synscapes.standin import annotate, frames
from foggy_synscapes.standin.layouts.layout import Files, StandIn


@dataclass(frozen=True)
class SynscapesFrame:
    """Frame `id` (from 1) of Synscapes."""

    seed: int
    size: tuple[int, int]
    id: int

    def paths(self) -> list[str]:
        """Files of the frame below the root."""
        return [
            name(self.id)
            for name in (synscapes.rgb, synscapes.depth, synscapes.class_, synscapes.instance, synscapes.meta)
        ]

    def files(self) -> Files:
        """Render the frame."""
        scene = frames.synscapes(self.seed, self.id - 1, self.size)
        camera = {"extrinsic": scene.rig.extrinsic(), "intrinsic": scene.rig.intrinsic()}
        meta = {"camera": camera, "instance": scene.instance, "scene": scene.scene}
        instances = annotate.instance_colours(scene.instances)
        return list(zip(self.paths(), (scene.rgb, scene.depth, scene.label_ids, instances, meta), strict=True))


def frames_of(plan: Any) -> list[SynscapesFrame]:
    """All frames, in the order of their ids."""
    return [SynscapesFrame(plan.seed, plan.size, number) for number in range(1, plan.synscapes + 1)]


STAND_IN = StandIn(counts=Count, text="of the whole dataset", published="25,000", frames=frames_of)
