"""Cityscapes on disk: `leftImg8bit`, `rightImg8bit`, `gtFine`, `disparity` and `camera`, by split and city.

A frame is named by split and stem, e.g. `train/aachen/aachen_000000_000019`.
"""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from foggy_synscapes.datasets.dataset import Dataset
from foggy_synscapes.errors import FoggyError

# Paths below the root, by the name of a frame.
image = "leftImg8bit/{}_leftImg8bit.png".format
labels = "gtFine/{}_gtFine_labelIds.png".format
instances = "gtFine/{}_gtFine_instanceIds.png".format
right = "rightImg8bit/{}_rightImg8bit.png".format
disparity = "disparity/{}_disparity.png".format  # 16-bit, (value - 1) / 256 pixels, 0 where missing
camera = "camera/{}_camera.json".format


def frames(paths: Iterable[str], split: str) -> list[str]:
    """Frames of a split that have an image among the paths below the root, sorted."""
    before, after = "leftImg8bit/", "_leftImg8bit.png"
    return sorted(
        path[len(before) : -len(after)]
        for path in paths
        if path.startswith(f"{before}{split}/") and path.endswith(after)
    )


def pairs(paths: Iterable[str], split: str = "val") -> list[tuple[str, str]]:
    """(image, labelIds) paths below the root of every frame of a split."""
    return [(image(frame), labels(frame)) for frame in frames(paths, split)]


def files(root: Path, _scenes: Any, _part: str) -> list[str]:
    """Image and labelIds of every training and validation frame; FoggyError if there is no image of them."""
    images = [path.relative_to(root).as_posix() for path in (root / "leftImg8bit").glob("*/*/*") if _is_image(path)]
    found = [path for split in ("train", "val") for pair in pairs(images, split) for path in pair]
    if not found:
        raise FoggyError(f"{root}: no leftImg8bit/train or leftImg8bit/val images. Is this the Cityscapes folder?")
    return found


def _is_image(path: Path) -> bool:
    """Whether a file is an image; FoggyError if it would be one but for its spelling, or lies in another city."""
    name, city = path.name, path.parent.name
    if name.startswith(".") or not name.lower().endswith("_leftimg8bit.png"):
        return False
    if not name.endswith("_leftImg8bit.png"):
        raise FoggyError(f"{path}: its name should end in _leftImg8bit.png, letter by letter. Was it renamed?")
    if not name.startswith(f"{city}_"):
        raise FoggyError(f"{path}: is of another city than {city}, in whose folder it lies. Was it moved?")
    return True


def tested(_root: Path, index: Mapping[str, str], _scenes: Any) -> list[tuple[str, str]]:
    """The clear validation frames, as the index lists them."""
    return sorted(pairs(index))


DATASET = Dataset(
    title="clear Cityscapes validation",
    short_title="clear Cityscapes, val",
    files=files,
    test_pairs=tested,
    pixels=2048 * 1024,
    tests=lambda _scenes: 500,
    folders=("leftImg8bit", "gtFine"),
    home="leftImg8bit_trainvaltest.zip and gtFine_trainvaltest.zip of cityscapes-dataset.com",
)
