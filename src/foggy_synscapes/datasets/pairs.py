"""The images and label maps of a list of `subset`, decoded and checked."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from foggy_synscapes.datasets.uris import RECIPE, Reader
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.images import read_ids, read_rgb
from foggy_synscapes.io.progress import progress
from foggy_synscapes.io.tables import read_csv
from foggy_synscapes.labels import encoding, to_train_ids

FIRST = 8
"""Label maps that are looked at before a list is trusted to hold labelIds."""
COLUMNS = ("image", "image_sha256", "label", "label_sha256")

Composite = Callable[[bytes, Callable[[str, str], bytes], str], np.ndarray]
"""Makes the foggy image of a recipe, from a reader of URIs; the last argument names the recipe in errors."""
Pair = tuple[np.ndarray, np.ndarray]  # image uint8 (H, W, 3) and labels uint8 (H, W), trainIds


class PairDataset:
    """A list's samples by index; decoded ones stay in memory while they fit into a budget.

    path : CSV with `COLUMNS`; reader : reads what it names; budget : bytes
    composite : makes the images of which the list names recipes
    count : samples in the list; held : bytes that stay in memory

    Raises FoggyError if the list is empty or cannot be read, and on what `load` refuses in the samples that are kept.
    """

    def __init__(self, path: Path, reader: Reader, budget: int, composite: Composite) -> None:
        self._rows = _rows(path, COLUMNS)
        self._reader, self._composite = reader, composite
        _check_encoding(reader, self._rows, path)
        self._memory: dict[int, Pair] = {}
        self.count, self.held = len(self._rows), 0
        for index in progress(range(self.count), f"read {path.parent.name} {path.stem}"):
            pair = self._decode(self._rows[index])
            if self.held + _size(pair) > budget:
                break
            self._memory[index] = pair
            self.held += _size(pair)

    def load(self, index: int) -> Pair:
        """Image and trainIds of a sample.

        Raises FoggyError if a file is missing, changed since it was listed, no image, or no map of labelIds; or if the
        two are not of one size.
        """
        return self._memory[index] if index in self._memory else self._decode(self._rows[index])

    def name(self, index: int) -> str:
        """URI of a sample's image."""
        return self._rows[index]["image"]

    def _decode(self, row: Mapping[str, str]) -> Pair:
        image, ids = _image(self._reader, row, self._composite), _ids(self._reader, row)
        if image.shape[:2] != ids.shape:
            raise FoggyError(
                f"{row['label']}: {ids.shape[0]} x {ids.shape[1]} pixels, but {row['image']} has "
                f"{image.shape[0]} x {image.shape[1]}. Do they belong together?"
            )
        try:
            return image, to_train_ids(ids, row["label"])
        except ValueError as error:
            raise FoggyError(str(error)) from error


def calibration_images(path: Path, reader: Reader, count: int, composite: Composite) -> list[np.ndarray]:
    """So many images of a list, spread evenly over it, to find the ranges of numbers that a network meets.

    All where the list has fewer; uint8 (H, W, 3). Raises FoggyError as `PairDataset` does.
    """
    rows = _rows(path, COLUMNS[:2])
    count = min(count, len(rows))
    return [_image(reader, rows[number * len(rows) // count], composite) for number in range(count)]


def _rows(path: Path, columns: Sequence[str]) -> list[dict[str, str]]:
    rows = read_csv(path, columns)
    if not rows:
        raise FoggyError(f"{path}: lists no image")
    return rows


def _image(reader: Reader, row: Mapping[str, str], composite: Composite) -> np.ndarray:
    uri = row["image"]
    data = reader.read(uri, row["image_sha256"])
    return composite(data, reader.read, uri) if uri.endswith(RECIPE) else read_rgb(data, uri)


def _ids(reader: Reader, row: Mapping[str, str]) -> np.ndarray:
    return read_ids(reader.read(row["label"], row["label_sha256"]), row["label"])


def _check_encoding(reader: Reader, rows: list[dict[str, str]], path: Path) -> None:
    """Refuse a list whose first maps hold no id that only labelIds have: one map alone need not tell, several do."""
    ids: set[int] = set()
    for row in rows[:FIRST]:
        ids |= set(np.unique(_ids(reader, row)).tolist())
        if encoding(ids) == "labelIds":
            return
    raise FoggyError(
        f"{path}: the first {min(FIRST, len(rows))} label maps hold the ids {sorted(ids)}, among them neither "
        "vegetation, sky nor any vehicle or person as labelIds (19 to 33). Are these trainIds, not labelIds?"
    )


def _size(pair: Pair) -> int:
    return pair[0].nbytes + pair[1].nbytes
