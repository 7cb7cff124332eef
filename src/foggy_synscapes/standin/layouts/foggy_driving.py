"""The stand-in of Foggy Driving."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from foggy_synscapes.datasets import foggy_driving
from foggy_synscapes.schema import Section, setting
from foggy_synscapes.standin import annotate, frames
from foggy_synscapes.standin.layouts.layout import Files, StandIn, lines

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


@dataclass(frozen=True)
class DrivingFrame:
    """Frame `number` (from 0) of the finely or coarsely annotated part of Foggy Driving."""

    seed: int
    size: tuple[int, int]
    number: int
    coarse: bool

    def name(self) -> str:
        """Source and stem."""
        source = SOURCES[self.number % len(SOURCES)]
        return f"{source}/{source}_20190{2 if self.coarse else 1}01_{self.number:06d}"

    def dense(self) -> bool:
        """Whether the frame is in the list of densely foggy ones."""
        return self.beta() >= DENSE

    def beta(self) -> float:
        """Density of the fog in 1/m."""
        return BETAS[self.number % len(BETAS)]

    def paths(self) -> list[str]:
        """Files of the frame below the root: image, labelIds and, if fine, instance ids beside them."""
        labels_path = foggy_driving.labels(self.name(), self.coarse)
        paths = [foggy_driving.image(self.name(), self.coarse), labels_path]
        return paths if self.coarse else [*paths, labels_path.replace("_labelIds", "_instanceIds")]

    def photograph(self) -> frames.Photograph:
        """The frame as arrays; its size varies from frame to frame."""
        key = (self.seed, COARSE if self.coarse else FINE, self.number)
        rows, columns = SIZES[int(np.random.default_rng((*key, 2)).integers(len(SIZES)))]
        size = max(16, round(self.size[0] * rows)), max(16, round(self.size[1] * columns))
        shot = frames.photograph(key, size, self.beta(), trains=True)
        return replace(shot, label_ids=annotate.coarsen(shot.label_ids)) if self.coarse else shot

    def files(self) -> Files:
        """Render the frame."""
        shot = self.photograph()
        contents = [shot.rgb, shot.label_ids]
        if not self.coarse:
            contents.append(annotate.instance_ids(shot.label_ids, shot.instances))
        return list(zip(self.paths(), contents, strict=True))


def frames_of(plan: Any) -> list[DrivingFrame]:
    """The finely, then the coarsely annotated frames."""
    counts = plan.foggy_driving
    return [
        DrivingFrame(plan.seed, plan.size, k, coarse)
        for coarse, count in ((False, counts.fine), (True, counts.coarse))
        for k in range(count)
    ]


def lists(chosen: Sequence[DrivingFrame], _scenes: Any) -> Files:
    """The five list files of Foggy Driving, with the names and line form of the real ones."""
    dense, fine = [frame for frame in chosen if frame.dense()], [frame for frame in chosen if not frame.coarse]
    folder = "lists_file_names"
    return [
        lines(foggy_driving.LABELS, (frame.paths()[1] for frame in chosen)),
        lines(f"{folder}/gt_testdense_filenames.txt", (frame.paths()[1] for frame in dense)),
        lines(foggy_driving.IMAGES, (frame.paths()[0] for frame in chosen)),
        lines(f"{folder}/leftImg8bit_testdense_filenames.txt", (frame.paths()[0] for frame in dense)),
        lines(f"{folder}/leftImg8bit_testfine_filenames.txt", (frame.paths()[0] for frame in fine)),
    ]


STAND_IN = StandIn(
    counts=DrivingCounts, text="with fine and with coarse labels", published="33 and 68", frames=frames_of, lists=lists
)
