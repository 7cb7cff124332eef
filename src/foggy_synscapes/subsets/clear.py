"""Lists of Cityscapes images: clear weather."""

from collections.abc import Iterator

from foggy_synscapes.datasets import cityscapes, uris
from foggy_synscapes.datasets.index import expect
from foggy_synscapes.subsets.kind import Kind, Line, Lists, Row, Sources, take


def lists(sources: Sources, entry: Row, key: str) -> Lists:
    """The first frames of both splits."""
    index = sources.index("cityscapes")

    def lines(split: str, count: int, part: str) -> list[Line]:
        frames = take(cityscapes.frames(index, split), count, f"{key}.{part}")
        return list(labelled(index, index, [(cityscapes.image(frame), frame) for frame in frames], "cityscapes"))

    return lines("train", entry.train, "train"), lines("val", entry.validation, "validation")


def labelled(
    images: dict[str, str], labels: dict[str, str], named: list[tuple[str, str]], dataset: str
) -> Iterator[Line]:
    """Lines of the images (path, frame) of a dataset whose label maps are those of Cityscapes."""
    expect(images, (image for image, _ in named), dataset)
    expect(labels, (cityscapes.labels(frame) for _, frame in named), "cityscapes")
    for image, frame in named:
        label = cityscapes.labels(frame)
        yield uris.of_dataset(dataset, image), images[image], uris.of_dataset("cityscapes", label), labels[label]


KIND = Kind(text="lists of Cityscapes: clear weather", entry=Row, reads=("cityscapes",), lists=lists, order=0)
