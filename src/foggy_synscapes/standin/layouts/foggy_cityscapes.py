"""The stand-in of Foggy Cityscapes: fog on the refined ones of the frames of Cityscapes' stand-in."""

from typing import Any

from foggy_synscapes.datasets import foggy_cityscapes
from foggy_synscapes.standin import fog
from foggy_synscapes.standin.layouts import cityscapes
from foggy_synscapes.standin.layouts.layout import Files, Frame, StandIn, lines
from foggy_synscapes.standin.style import is_blue

BETAS = foggy_cityscapes.BETAS


def refined(plan: Any, counts: cityscapes.CityscapesCounts) -> list[tuple[str, int]]:
    """Splits and numbers of so many refined frames: of those without a blue sky, spread evenly.

    Raises ValueError if there are fewer.
    """
    chosen = []
    for split, stream in cityscapes.STREAMS.items():
        numbers, count = range(getattr(plan.cityscapes, split)), getattr(counts, split)
        fitting = [number for number in numbers if not is_blue((plan.seed, stream), number)]
        if count > len(fitting):
            raise ValueError(f"{count} refined frames of {len(fitting)} without a blue sky; ask for fewer")
        chosen += [(split, fitting[k * len(fitting) // count]) for k in range(count)]
    return chosen


def _render(seed: int, size: tuple[int, int], split: str, number: int) -> list[Any]:
    # The clear frame, made again from its seed, in fog.
    return fog.from_stereo(*cityscapes.scene(seed, size, split, number), [float(beta) for beta in BETAS])


def _frames(plan: Any) -> list[Frame]:
    return [
        Frame(
            [foggy_cityscapes.image(cityscapes.name(plan, *clear), beta) for beta in BETAS],
            _render,
            (plan.seed, plan.size, *clear),
        )
        for clear in refined(plan, plan.foggy_cityscapes)
    ]


def _list(_frames: list[Frame], scenes: Any) -> Files:
    plan = scenes.stand_in
    names = (cityscapes.name(plan, *clear) for clear in refined(plan, plan.foggy_cityscapes))
    return [lines(scenes.refined_list, names)]


def _check(plan: Any) -> None:
    for split in cityscapes.STREAMS:
        refined, count = getattr(plan.foggy_cityscapes, split), getattr(plan.cityscapes, split)
        if refined > count:
            raise ValueError(f"foggy_cityscapes.{split}: {refined} refined frames of only {count} Cityscapes frames")


STAND_IN = StandIn(
    counts=cityscapes.CityscapesCounts,
    text="refined ones of each split",
    published="498 and 52",
    frames=_frames,
    lists=_list,
    others=("cityscapes",),
    check=_check,
)
