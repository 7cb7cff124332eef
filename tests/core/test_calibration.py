"""Images to calibrate on come from all over a training list, rendered or composited."""

from pathlib import Path

import numpy as np
import pytest

from foggy_synscapes.datasets.pairs import calibration_images
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.images import encode_png
from foggy_synscapes.io.tables import write_csv


class Numbered:
    """Reads image N as an image whose pixels are all N."""

    def read(self, uri: str, sha256: str) -> bytes:
        return encode_png(np.full((4, 6, 3), int(uri.split(".")[0]), np.uint8))


def never(*_rest: object) -> np.ndarray:
    raise AssertionError("no recipe is named")


def listed(folder: Path, *names: str) -> Path:
    write_csv(folder / "list.csv", ("image", "image_sha256"), [(name, "") for name in names])
    return folder / "list.csv"


def test_they_are_spread_evenly(tmp_path: Path) -> None:
    path = listed(tmp_path, *(f"{number}.png" for number in range(10)))
    images = calibration_images(path, Numbered(), 4, never)
    assert [int(image[0, 0, 0]) for image in images] == [0, 2, 5, 7]
    assert len(calibration_images(path, Numbered(), 99, never)) == 10


def test_recipes_are_composited(tmp_path: Path) -> None:
    def composite(data: bytes, read: object, called: str) -> np.ndarray:
        assert called == "1.json"
        return np.full((4, 6, 3), 77, np.uint8)

    images = calibration_images(listed(tmp_path, "0.png", "1.json"), Numbered(), 2, composite)
    assert [int(image[0, 0, 0]) for image in images] == [0, 77]


def test_an_empty_list_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FoggyError, match="lists no image"):
        calibration_images(listed(tmp_path), Numbered(), 2, never)
