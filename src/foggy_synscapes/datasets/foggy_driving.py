"""Foggy Driving on disk: 33 finely labelled images in `test`, 68 coarsely labelled ones in `test_extra`.

`leftImg8bit/SPLIT/SOURCE/NAME_leftImg8bit.png` with `gtFine/test/SOURCE/NAME_gtFine_labelIds.png` or
`gtCoarse/test_extra/SOURCE/NAME_gtCoarse_labelIds.png`; SOURCE is pedestrian, public or web. Sizes vary.
Source: Sakaridis, Dai and Van Gool, Semantic Foggy Scene Understanding with Synthetic Data, IJCV 2018.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from foggy_synscapes.datasets.dataset import Dataset
from foggy_synscapes.datasets.lists import paired, read_list

IMAGES = "lists_file_names/leftImg8bit_testall_filenames.txt"
LABELS = "lists_file_names/gt_testall_filenames.txt"


def image(name: str, coarse: bool) -> str:
    """Path of an image, e.g. of `web/web_8050286343_fb56b08ce7`, below the root."""
    return f"leftImg8bit/{'test_extra' if coarse else 'test'}/{name}_leftImg8bit.png"


def labels(name: str, coarse: bool) -> str:
    """Path of the labelIds below the root."""
    return f"gtCoarse/test_extra/{name}_gtCoarse_labelIds.png" if coarse else f"gtFine/test/{name}_gtFine_labelIds.png"


def pairs(root: str | Path, index: Mapping[str, str] | None = None) -> list[tuple[str, str]]:
    """(image, labelIds) paths below the root, as the dataset's own lists pair them; `index` as in `lists.read_text`."""
    images, maps = (read_list(Path(root), name, index) for name in (IMAGES, LABELS))
    return paired(images, maps, "Foggy Driving")


def files(root: Path, _scenes: Any, _part: str) -> list[str]:
    """The lists of all images and label maps, and what they name."""
    return [IMAGES, LABELS, *(path for pair in pairs(root) for path in pair)]


def tested(root: Path, index: Mapping[str, str], _scenes: Any) -> list[tuple[str, str]]:
    """All 101 images, finely and coarsely labelled."""
    return sorted(pairs(root, index))


DATASET = Dataset(title="Foggy Driving", short_title="Foggy Driving", files=files, test_pairs=tested)
