"""The test sets: which images they consist of, whatever their layout."""

from collections.abc import Mapping
from pathlib import Path

from foggy_synscapes.datasets import cityscapes, foggy_driving, foggy_zurich

TEST_SETS = ("foggy_driving", "foggy_zurich", "cityscapes")


def labelled_pairs(test_set: str, root: Path, index: Mapping[str, str], zurich_list: str) -> list[tuple[str, str]]:
    """(image, labelIds) paths of a test set below its root, sorted.

    Parameters
    ----------
    test_set : foggy_driving, foggy_zurich, or cityscapes for its clear validation frames
    index : SHA-256 by path; list files must be as listed there, and the frames of Cityscapes are taken from it
    zurich_list : testv2 (40 images) or testv1 (16), of Foggy Zurich's own lists
    """
    if test_set == "foggy_driving":
        return sorted(foggy_driving.pairs(root, index))
    if test_set == "foggy_zurich":
        return sorted(foggy_zurich.pairs(root, zurich_list, index))
    return sorted(cityscapes.pairs(index, "val"))
