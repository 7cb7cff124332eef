"""Lists that mix Foggy Synscapes with Foggy Cityscapes."""

from itertools import cycle, islice

from foggy_synscapes.schema import Beta, Count, setting
from foggy_synscapes.subsets import partial, pure
from foggy_synscapes.subsets.kind import FoggyRow, Kind, Line, Lists, Sources


class MixedRow(FoggyRow):
    """A list that mixes Foggy Synscapes with Foggy Cityscapes; counts are those of Foggy Synscapes."""

    beta_foggy_cityscapes: Beta = setting("that of the Foggy Cityscapes images", unit="1/m")
    ratio: tuple[Count, Count] = setting(
        "Foggy Synscapes : Foggy Cityscapes", published="[2, 1]", source="section IV.C"
    )

    def counts(self) -> tuple[int, int]:
        """Number of entries of the training and of the validation list."""
        return self.train + share(self.train, *self.ratio), self.validation + share(self.validation, *self.ratio)


def share(count: int, synscapes: int, cityscapes: int) -> int:
    """How many Foggy Cityscapes images go with `count` Foggy Synscapes images at a ratio of synscapes : cityscapes.

    >>> share(498, 2, 1), share(5, 2, 1)
    (249, 3)
    """
    return -(-count * cityscapes // synscapes)


def interleave(synscapes: list[Line], cityscapes: list[Line], ratio: tuple[int, int]) -> list[Line]:
    """Mix two lists group by group at a ratio; the second starts again from its first line where it ends.

    >>> "".join(interleave(list("aaaa"), list("xyz"), (2, 1)))
    'aaxaay'
    """
    first, second = ratio
    again = cycle(cityscapes)
    mixed: list[Line] = []
    left = share(len(synscapes), first, second)
    for start in range(0, len(synscapes), first):
        mixed += synscapes[start : start + first]
        taken = min(second, left)
        mixed += islice(again, taken)
        left -= taken
    return mixed


def lists(sources: Sources, entry: MixedRow, key: str) -> Lists:
    """Kept frames as a list of Foggy Synscapes takes them, among all refined frames (paper, section IV.C)."""
    synscapes = pure.lists(sources, entry, key)
    cityscapes = partial.refined(sources, entry.beta_foggy_cityscapes, (None, None), key)
    train, validation = (interleave(*both, entry.ratio) for both in zip(synscapes, cityscapes, strict=True))
    return train, validation


KIND = Kind(
    text="lists of Foggy Synscapes and Foggy Cityscapes; counts are those of Foggy Synscapes",
    order=3,
    entry=MixedRow,
    reads=(*partial.KIND.reads, *pure.KIND.reads),
    lists=lists,
    keys=(*partial.KIND.keys, *pure.KIND.keys),
)
