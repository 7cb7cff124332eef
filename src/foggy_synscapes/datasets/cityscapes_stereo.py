"""The stereo part of Cityscapes: what fog on its frames is made of, beside the labels of `cityscapes`.

These are downloads of their own (rightImg8bit, disparity, camera), unpacked into the folder of Cityscapes.
"""

from pathlib import Path
from typing import Any

from foggy_synscapes.datasets import cityscapes, foggy_cityscapes
from foggy_synscapes.datasets.dataset import Dataset
from foggy_synscapes.errors import FoggyError

ALL = "all"
KINDS = (cityscapes.image, cityscapes.right, cityscapes.disparity, cityscapes.camera, cityscapes.instances)


def paths(frame: str) -> list[str]:
    """Files of a frame below the root."""
    return [kind(frame) for kind in KINDS]


def files(root: Path, scenes: Any, _part: str) -> list[str]:
    """Both views, disparity, camera and instance ids of the frames that `scenes.stereo_list` names, or of all that have
    a right view.

    Raises FoggyError if there is no frame, or the list is missing or wrong.
    """
    if scenes.stereo_list != ALL:
        listed = foggy_cityscapes.read_refined(root, scenes.stereo_list)
        names = [name for split in listed.values() for name in split]
    else:
        images = [path.relative_to(root).as_posix() for path in (root / "leftImg8bit").glob("*/*/*_leftImg8bit.png")]
        every = [name for split in ("train", "val") for name in cityscapes.frames(images, split)]
        names = [name for name in every if (root / cityscapes.right(name)).is_file()]
    if not names:
        raise FoggyError(
            f"{root}: no image of leftImg8bit/train or leftImg8bit/val that has one in rightImg8bit. Is this the "
            "Cityscapes folder, with rightImg8bit unpacked beside leftImg8bit?"
        )
    return [path for name in names for path in paths(name)]


DATASET = Dataset(
    title="Cityscapes, stereo", short_title="Cityscapes, stereo", files=files, settings=("scenes.stereo_list",)
)
