"""Foggy Cityscapes on disk: `leftImg8bit_foggy/SPLIT/CITY/..._leftImg8bit_foggy_beta_0.01.png`.

Labels are those of Cityscapes. The refined subset is a list file in the root: one frame a line, as split, city and
stem, e.g. `train/aachen/aachen_000000_000019`; 498 of the training and 52 of the validation split.
Source: Sakaridis, Dai and Van Gool, Semantic Foggy Scene Understanding with Synthetic Data, IJCV 2018.
"""

import re
from pathlib import Path

from foggy_synscapes.errors import FoggyError

BETAS = ("0.005", "0.01", "0.02")
"""Attenuation coefficients in 1/m in which the dataset is published."""

_FRAME = re.compile(r"^(train|val)/([a-z-]+)/(\2_\d{6}_\d{6})$")


def image(frame: str, beta: str) -> str:
    """Path of the foggy image of a frame below the root."""
    return f"leftImg8bit_foggy/{frame}_leftImg8bit_foggy_beta_{beta}.png"


def read_refined(path: str | Path) -> dict[str, list[str]]:
    """Frames of the refined subset by split, in the order of the list.

    Raises
    ------
    FoggyError
        If the list is missing or a line is not `SPLIT/CITY/CITY_SSSSSS_FFFFFF`.
    """
    try:
        lines = Path(path).read_text(encoding="utf-8").split("\n")
    except (OSError, UnicodeDecodeError) as error:
        raise FoggyError(
            f"{path}: the list of refined images cannot be read: {error}. See scenes.refined_list."
        ) from error
    found: dict[str, list[str]] = {"train": [], "val": []}
    for number, line in enumerate(lines, start=1):
        if not line.strip():
            continue
        match = _FRAME.match(line.strip())
        if match is None:
            raise FoggyError(
                f"{path}, line {number}: {line.strip()[:80]!r} is not like train/aachen/aachen_000000_000019"
            )
        found[match[1]].append(match[0])
    return found
