"""Foggy Cityscapes on disk: `leftImg8bit_foggy/SPLIT/CITY/..._leftImg8bit_foggy_beta_0.01.png`.

Labels are those of Cityscapes. The refined subset is a list file in the root: one frame a line, as split, city and
stem, e.g. `train/aachen/aachen_000000_000019`; 498 of the training and 52 of the validation split.
Source: Sakaridis, Dai and Van Gool, Semantic Foggy Scene Understanding with Synthetic Data, IJCV 2018.
"""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from foggy_synscapes.datasets.dataset import Dataset
from foggy_synscapes.datasets.lists import read_text
from foggy_synscapes.errors import FoggyError

BETAS = ("0.005", "0.01", "0.02")
"""Attenuation coefficients in 1/m in which the dataset is published."""

_FRAME = re.compile(r"^(train|val)/([a-z-]+)/(\2_\d{6}_\d{6})$")


def image(frame: str, beta: str) -> str:
    """Path of the foggy image of a frame below the root."""
    return f"leftImg8bit_foggy/{frame}_leftImg8bit_foggy_beta_{beta}.png"


def read_refined(root: Path, name: str, index: Mapping[str, str] | None = None) -> dict[str, list[str]]:
    """Frames of the refined subset by split, in the order of the list; `index` as in `lists.read_text`.

    Raises
    ------
    FoggyError
        If the list is missing or not as listed; if a line is not `SPLIT/CITY/CITY_SSSSSS_FFFFFF` or stands there twice.
    """
    path, lines = root / name, read_text(root, name, index).split("\n")
    found: dict[str, list[str]] = {"train": [], "val": []}
    for number, line in enumerate(lines, start=1):
        if not line.strip():
            continue
        match = _FRAME.match(line.strip())
        if match is None:
            raise FoggyError(
                f"{path}, line {number}: {line.strip()[:80]!r} is not like train/aachen/aachen_000000_000019"
            )
        if match[0] in found[match[1]]:
            raise FoggyError(f"{path}, line {number}: {match[0]} stands there twice")
        found[match[1]].append(match[0])
    return found


def files(root: Path, scenes: Any, _part: str) -> list[str]:
    """The refined list and its frames at every beta of which there is an image; FoggyError if there is none."""
    refined = read_refined(root, scenes.refined_list)
    names = [frame for frames in refined.values() for frame in frames]
    if not names:
        raise FoggyError(f"{root / scenes.refined_list}: names no frame")
    betas = [beta for beta in BETAS if any((root / image(name, beta)).is_file() for name in names)]
    if not betas:
        raise FoggyError(
            f"{root}: no leftImg8bit_foggy image of the refined frames. Is this the Foggy Cityscapes folder?"
        )
    return [scenes.refined_list, *(image(name, beta) for name in names for beta in betas)]


DATASET = Dataset(
    title="Foggy Cityscapes",
    short_title="Foggy Cityscapes",
    files=files,
    settings=("scenes.refined_list",),
    pixels=2048 * 1024,
    folders=("leftImg8bit_foggy",),
    home=(
        "leftImg8bit_trainvaltest_foggy.zip of cityscapes-dataset.com, and the list of the refined images that "
        "scenes.refined_list names"
    ),
)
