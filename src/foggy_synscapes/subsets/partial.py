"""Lists of refined Foggy Cityscapes images: partially synthetic."""

from foggy_synscapes.datasets import foggy_cityscapes
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.subsets.clear import labelled
from foggy_synscapes.subsets.kind import FoggyRow, Kind, Lists, Sources, take


def lists(sources: Sources, entry: FoggyRow, key: str) -> Lists:
    """The first refined frames of both splits."""
    return refined(sources, entry.beta, (entry.train, entry.validation), key)


def refined(sources: Sources, beta: str, counts: tuple[int | None, int | None], key: str) -> Lists:
    """Refined images of both splits; a count of None takes all."""
    labels, images = sources.index("cityscapes"), sources.index("foggy_cityscapes")
    folder, name = sources.roots["foggy_cityscapes"], sources.scenes.refined_list
    listed = foggy_cityscapes.read_refined(folder, name, images)
    result = []
    for split, count, part in zip(("train", "val"), counts, ("train", "validation"), strict=True):
        frames = listed[split] if count is None else take(listed[split], count, f"{key}.{part}")
        if not frames:
            raise FoggyError(f"{folder / name}: names no frame of the {split} split")
        named = [(foggy_cityscapes.image(frame, beta), frame) for frame in frames]
        result.append(list(labelled(images, labels, named, "foggy_cityscapes")))
    return result[0], result[1]


KIND = Kind(
    text="lists of Foggy Cityscapes, refined: partially synthetic",
    order=1,
    entry=FoggyRow,
    reads=("cityscapes", "foggy_cityscapes"),
    lists=lists,
    keys=("scenes.refined_list",),
)
