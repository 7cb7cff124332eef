"""Lists of Foggy Cityscapes made here from stereo: partially synthetic, at any beta."""

from foggy_synscapes.datasets import cityscapes, uris
from foggy_synscapes.datasets.index import expect
from foggy_synscapes.subsets.kind import MADE, FoggyRow, Kind, Line, Lists, Sources, take


def lists(sources: Sources, entry: FoggyRow, key: str) -> Lists:
    """The first frames of both splits, by name."""
    labels, members = sources.index("cityscapes"), sources.foggy(MADE)

    def lines(split: str, count: int, part: str) -> list[Line]:
        names = take(sorted(name for name in members if name.split("/")[1] == split), count, f"{key}.{part}")
        found = []
        for name in names:
            (shard, digest), label = members[name], cityscapes.labels(frame_of(name))
            expect(labels, [label], "cityscapes")
            image = uris.of_made(entry.beta, shard, name)
            found.append((image, digest, uris.of_dataset("cityscapes", label), labels[label]))
        return found

    return lines("train", entry.train, "train"), lines("val", entry.validation, "validation")


def frame_of(name: str) -> str:
    """Split, city and stem of a foggy image's name.

    >>> frame_of("leftImg8bit_foggy/val/lindau/lindau_000000_000019_leftImg8bit_foggy_beta_0.01.png")
    'val/lindau/lindau_000000_000019'
    """
    return name.partition("/")[2].partition("_leftImg8bit_")[0]


KIND = Kind(
    text="lists of Foggy Cityscapes made here from stereo: partially synthetic",
    order=2,
    entry=FoggyRow,
    reads=("cityscapes", MADE),
    lists=lists,
)
