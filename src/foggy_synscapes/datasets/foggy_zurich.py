"""Foggy Zurich on disk: `RGB/SEQ/ID.png`, `gt_labelIds/SEQ/ID.png`, `gt_labelTrainIds/SEQ/ID.png`, and lists.

Its ground truth has no train class. testv2 names 40 images, testv1 16.
Source: Dai, Sakaridis, Hecker and Van Gool, Curriculum Model Adaptation, IJCV 2020.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from foggy_synscapes.datasets.dataset import Dataset
from foggy_synscapes.datasets.lists import paired, read_list


def image(name: str) -> str:
    """Path of an image, e.g. of `GP010229/1508040913.0_frame_000955`, below the root."""
    return f"RGB/{name}.png"


def labels(name: str) -> str:
    """Path of the labelIds below the root."""
    return f"gt_labelIds/{name}.png"


def train_labels(name: str) -> str:
    """Path of the trainIds below the root."""
    return f"gt_labelTrainIds/{name}.png"


def list_path(kind: str, version: str = "testv2") -> str:
    """Path of the list of RGB, gt_labelIds or gt_labelTrainIds files below the root."""
    return f"lists_file_names/{kind}_{version}_filenames.txt"


def pairs(root: str | Path, version: str = "testv2", index: Mapping[str, str] | None = None) -> list[tuple[str, str]]:
    """(image, labelIds) paths below the root, as the dataset's own lists pair them; `index` as in `lists.read_text`."""
    images, maps = (read_list(Path(root), list_path(kind, version), index) for kind in ("RGB", "gt_labelIds"))
    return paired(images, maps, "Foggy Zurich")


def files(root: Path, scenes: Any, _part: str) -> list[str]:
    """The lists of images and labelIds of the chosen version, and what they name."""
    version = scenes.zurich_list
    lists = [list_path(kind, version) for kind in ("RGB", "gt_labelIds")]
    return [*lists, *(path for pair in pairs(root, version) for path in pair)]


def tested(root: Path, index: Mapping[str, str], scenes: Any) -> list[tuple[str, str]]:
    """The images of the chosen version."""
    return sorted(pairs(root, scenes.zurich_list, index))


DATASET = Dataset(
    title="Foggy Zurich-test",
    short_title="Foggy Zurich",
    files=files,
    settings=("scenes.zurich_list",),
    test_pairs=tested,
)
