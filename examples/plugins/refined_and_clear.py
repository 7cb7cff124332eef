"""A kind of row: refined Foggy Cityscapes and clear Cityscapes, one image of each in turn.

This file's name is the key under `subset` in the params that holds the rows of this kind.
"""

from foggy_synscapes.subsets import clear, partial
from foggy_synscapes.subsets.kind import FoggyRow, Kind, Lists, Sources


class RefinedAndClearRow(FoggyRow):
    """An entry of the params: `train`, `validation` and `beta`; counts are those of each of the two datasets."""

    def counts(self) -> tuple[int, int]:
        """Number of entries of the training and of the validation list."""
        return 2 * self.train, 2 * self.validation


def lists(sources: Sources, entry: RefinedAndClearRow, key: str) -> Lists:
    """The first refined and the first clear frames of both splits, in turn."""
    both = zip(partial.lists(sources, entry, key), clear.lists(sources, entry, key), strict=True)
    train, validation = ([line for pair in zip(*each, strict=True) for line in pair] for each in both)
    return train, validation


KIND = Kind(
    text="lists of refined Foggy Cityscapes and clear Cityscapes in turn; counts are those of each",
    entry=RefinedAndClearRow,
    reads=partial.KIND.reads,
    keys=partial.KIND.keys,
    lists=lists,
)
