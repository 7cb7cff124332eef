"""The page of predictions: test images, their ground truth and what each row predicts."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from foggy_synscapes.labels import CLASSES, IGNORE, PALETTE
from foggy_synscapes.scoring.confusion import confusion_matrix
from foggy_synscapes.scoring.iou import iou, mean_annotated
from foggy_synscapes.view.colours import RIGHT, SAFE, WRONG
from foggy_synscapes.view.page import page
from foggy_synscapes.view.planes import bytes_text, file_text


@dataclass(frozen=True)
class Row:
    """A row of a network: their names, and its mean IoU on the whole test set in percent, None where undefined."""

    network: str
    row: str
    mean: float | None


@dataclass(frozen=True)
class Shown:
    """A test image: its name, a JPEG of it, its ground truth and the prediction of each row, trainIds uint8 (H, W)."""

    name: str
    photo: bytes
    truth: np.ndarray
    predictions: Sequence[np.ndarray]


def predictions_page(title: str, rows: Sequence[Row], images: Iterable[Shown], stand_in: bool = False) -> str:
    """A page on which any two of image, ground truth and rows are compared.

    images : taken one by one, with a prediction for each of the rows; stand_in : whether they are synthetic sample data

    Raises ValueError where there is no image or no row, or a prediction is of another size than its image.
    """
    shown: list[Mapping[str, Any]] = []
    blobs: dict[str, str] = {}
    for number, image in enumerate(images):
        shown.append(_facts(image))
        blobs |= dict(_blobs(number, image))
    if not shown or not rows:
        raise ValueError(f"{len(shown)} images of {len(rows)} rows, expected one of each at least")
    facts = {
        "title": title,
        "classes": CLASSES,
        "palettes": {"cityscapes": PALETTE.tolist(), "safe": SAFE.tolist()},
        "right": RIGHT,
        "wrong": WRONG,
        "rows": [vars(row) for row in rows],
        "images": shown,
        "standIn": stand_in,
    }
    return page("predictions", title, facts, blobs)


def _facts(image: Shown) -> Mapping[str, Any]:
    height, width = image.truth.shape
    scores = []
    for predicted in image.predictions:
        found = iou(confusion_matrix(image.truth, predicted, len(CLASSES), IGNORE))
        mean = mean_annotated(found)
        scores.append({"mean": _percent(mean), "classes": [_percent(score) for score in found]})
    pixels = np.bincount(image.truth.ravel(), minlength=len(CLASSES))[: len(CLASSES)]
    return {"name": image.name, "width": width, "height": height, "scores": scores, "pixels": pixels.tolist()}


def _percent(fraction: float) -> float | None:
    return None if np.isnan(fraction) else round(100 * float(fraction), 4)


def _blobs(number: int, image: Shown) -> Iterator[tuple[str, str]]:
    yield f"{number}-photo", file_text(image.photo)
    yield f"{number}-truth", bytes_text(image.truth)
    for place, predicted in enumerate(image.predictions):
        yield f"{number}-{place}", bytes_text(predicted)
