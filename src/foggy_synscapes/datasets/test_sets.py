"""The test sets: which images they consist of, whatever their layout."""

from collections.abc import Iterable
from pathlib import Path

from foggy_synscapes.datasets import cityscapes, foggy_driving, foggy_zurich


def labelled_pairs(test_set: str, root: Path, indexed: Iterable[str], zurich_list: str) -> list[tuple[str, str]]:
    """(image, labelIds) paths of a test set below its root, sorted.

    Parameters
    ----------
    test_set : foggy_driving, foggy_zurich, or cityscapes for its clear validation frames
    indexed : paths of the dataset's index, from which the frames of Cityscapes are taken
    zurich_list : testv2 (40 images) or testv1 (16), of Foggy Zurich's own lists
    """
    if test_set == "foggy_driving":
        return sorted(foggy_driving.pairs(root))
    if test_set == "foggy_zurich":
        return sorted(foggy_zurich.pairs(root, zurich_list))
    return sorted(cityscapes.pairs(indexed, "val"))
