"""The scores of a test set as one plain document: what `metrics.json` holds."""

import math
import os
from pathlib import Path
from typing import Any

import numpy as np

from foggy_synscapes.io.files import named, read_json
from foggy_synscapes.labels import CATEGORIES, CLASSES
from foggy_synscapes.scoring import iou


def summarize(matrix: np.ndarray, images: int) -> dict[str, Any]:
    """Scores of a confusion matrix of the 19 classes, in percent, None where undefined.

    matrix : int64 (19, 20), see `confusion.fold`; ValueError if it has another shape, or no pixel of a class
    images : number of images that were counted

    `confusion` holds rows of ground truth by columns of predictions; `unlabelled_predictions` the pixels of each class
    that are predicted as no class, which its `fn` includes. `mean_iou` has both conventions; `mean_iou_cityscapes` is
    that of the Cityscapes scripts, in which a class absent from the ground truth counts as 0 as soon as one pixel is
    predicted as it.
    """
    if matrix.shape != (len(CLASSES), len(CLASSES) + 1):
        raise ValueError(f"matrix: shape {matrix.shape}, expected {(len(CLASSES), len(CLASSES) + 1)}")
    if not matrix.any():
        raise ValueError("matrix: no pixel of the ground truth is labelled with any of the 19 classes")
    scores = iou.iou(matrix)
    index = {name: number for number, name in enumerate(CLASSES)}
    groups = {name: [index[member] for member in members] for name, members in CATEGORIES.items()}
    categories = iou.category_iou(matrix, groups)
    counts = zip(iou.true_positives(matrix), iou.false_positives(matrix), iou.false_negatives(matrix), strict=True)
    return {
        "classes": [
            {"name": name, "iou": _percent(score), "tp": int(tp), "fp": int(fp), "fn": int(fn)}
            for name, score, (tp, fp, fn) in zip(CLASSES, scores, counts, strict=True)
        ],
        "mean_iou": {
            "annotated": _percent(iou.mean_annotated(scores)),
            "as_published": _percent(iou.mean_as_published(scores)),
        },
        "annotated_classes": int(iou.annotated(matrix).sum()),
        "images": images,
        "mean_iou_cityscapes": _percent(iou.mean_annotated(iou.iou_as_cityscapes(matrix))),
        "pixel_accuracy": _percent(iou.pixel_accuracy(matrix)),
        "frequency_weighted_iou": _percent(iou.frequency_weighted_iou(matrix)),
        "categories": [{"name": name, "iou": _percent(score)} for name, score in categories.items()],
        "mean_category_iou": _percent(iou.mean_annotated(list(categories.values()))),
        "confusion": matrix[:, :-1].tolist(),
        "unlabelled_predictions": matrix[:, -1].tolist(),
    }


def _percent(fraction: float) -> float | None:
    return None if math.isnan(fraction) else 100.0 * float(fraction)


def check(document: Any) -> None:
    """Raise ValueError unless a document has the form of `summarize` and the 19 classes in their order."""
    try:
        names = [entry["name"] for entry in document["classes"]]
        if len(names) != len(CLASSES):
            raise ValueError(f"scores of {len(names)} classes, expected the {len(CLASSES)} of Cityscapes")
        for name, expected in zip(names, CLASSES, strict=True):
            if name != expected:
                raise ValueError(f"class {name!r} where {expected!r} is expected")
        scores = [entry["iou"] for entry in document["classes"]]
        means = [document["mean_iou"][convention] for convention in ("annotated", "as_published")]
        counts = [entry[key] for entry in document["classes"] for key in ("tp", "fp", "fn")] + [document["images"]]
        annotated = document["annotated_classes"]
    except (KeyError, TypeError) as error:
        raise ValueError(f"not the scores of a test set ({error!r})") from None
    for value in [score for score in scores if score is not None] + means:
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value <= 100:
            raise ValueError(f"IoU {value!r}, expected 0 to 100 percent")
    for value in counts:
        if isinstance(value, bool) or not isinstance(value, int) or value < 0:
            raise ValueError(f"count {value!r}, expected a whole number from 0 on")
    if annotated != sum(score is not None for score in scores):
        raise ValueError(f"{annotated} annotated classes, but another number of scores is defined")


def read_scores(path: Path) -> dict[str, Any] | None:
    """Scores of a run as `summarize` makes them, or None where the run was not made; FoggyError if they are damaged."""
    if not os.path.lexists(path):
        return None
    advice = "Was it made by `foggy evaluate`? Run that again."
    document = read_json(path, "file of metrics", advice)
    with named(path, "file of metrics", advice):
        check(document)
    return document
