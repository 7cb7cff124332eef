"""The stand-in of Foggy Zurich."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from foggy_synscapes.datasets import foggy_zurich
from foggy_synscapes.labels import to_train_ids
from foggy_synscapes.schema import Count
from foggy_synscapes.standin import frames
from foggy_synscapes.standin.layouts.layout import Files, StandIn, lines

STREAM = 13

BETAS = (0.007, 0.012, 0.016, 0.024, 0.036)
"""1/m, none of them a training beta (0.005, 0.01, 0.02, 0.03, 0.06)."""

SEQUENCES = ("GP010229", "GP020397")
"""Drives of Foggy Zurich."""


@dataclass(frozen=True)
class ZurichFrame:
    """Frame `number` (from 0) of Foggy Zurich."""

    seed: int
    size: tuple[int, int]
    number: int

    def name(self) -> str:
        """Sequence and id."""
        sequence, place = SEQUENCES[self.number % len(SEQUENCES)], self.number // len(SEQUENCES)
        return f"{sequence}/{1508040913 + self.number}.0_frame_{place * 15 + 10:06d}"

    def paths(self) -> list[str]:
        """Files of the frame below the root."""
        return [kind(self.name()) for kind in (foggy_zurich.image, foggy_zurich.labels, foggy_zurich.train_labels)]

    def photograph(self) -> frames.Photograph:
        """The frame as arrays, 16 : 9 and without trains."""
        size = max(16, round(self.size[1] * 9 / 16)), self.size[1]
        return frames.photograph((self.seed, STREAM, self.number), size, BETAS[self.number % len(BETAS)], trains=False)

    def files(self) -> Files:
        """Render the frame."""
        shot = self.photograph()
        train_ids = to_train_ids(shot.label_ids, self.name())
        return list(zip(self.paths(), (shot.rgb, shot.label_ids, train_ids), strict=True))


def frames_of(plan: Any) -> list[ZurichFrame]:
    """All frames."""
    return [ZurichFrame(plan.seed, plan.size, number) for number in range(plan.foggy_zurich)]


def lists(chosen: Sequence[ZurichFrame], _scenes: Any) -> Files:
    """The six list files of Foggy Zurich; testv1 names two of five frames, as 16 of 40 in the real set."""
    found = []
    for version, part in (("testv1", chosen[: max(1, len(chosen) * 2 // 5)]), ("testv2", chosen)):
        for k, kind in enumerate(("RGB", "gt_labelIds", "gt_labelTrainIds")):
            found.append(lines(foggy_zurich.list_path(kind, version), (frame.paths()[k] for frame in part)))
    return found


STAND_IN = StandIn(counts=Count, text="of the whole dataset", published="40", frames=frames_of, lists=lists)
