"""Scores of anyone's predictions: of a folder beside label maps, of a test set's images, or of arrays."""

import os
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from foggy_synscapes.datasets import DATASETS
from foggy_synscapes.datasets.predictions import count_pairs, count_paths, find_pairs, find_predictions
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.hashing import sha256
from foggy_synscapes.scoring.metrics import summarize
from foggy_synscapes.scoring.pairing import pair
from foggy_synscapes.scoring.tally import ASK, Tally


def of_folders(
    predictions: Path,
    labels: Path,
    predictions_encoding: str | None = None,
    labels_encoding: str | None = None,
    jobs: int = 1,
    say: Callable[[str], object] = lambda _note: None,
) -> dict[str, Any]:
    """Scores of a folder of predictions beside a folder of label maps, as `scoring.metrics.summarize` gives them.

    say : is told of files that are passed over

    Raises
    ------
    FoggyError
        If a file stays without its counterpart, is no 8-bit grey PNG, or differs in size from it; if the encoding
        is open or contradicted; if no pixel is labelled with a class.
    """
    found = find_pairs(labels, predictions, labels_encoding)
    if found.other_maps:
        say(f"{labels}: {found.other_maps} files are not maps of the ids asked for and are left out")
    tally = count_pairs(labels, predictions, found.pairs, jobs)
    where = f"labels: {labels}, predictions: {predictions}"
    if labels_encoding and labels_encoding == predictions_encoding:
        where += f"; both were to be {labels_encoding}: --labels-encoding and --predictions-encoding tell them apart"
    asked = labels_encoding, predictions_encoding
    return summary(tally, *asked, where, found.labels_named, found.predictions_named)


def of_test_set(
    name: str,
    root: Path,
    predictions: Path,
    scenes: Any = None,
    predictions_encoding: str | None = None,
    jobs: int = 1,
) -> dict[str, Any]:
    """Scores of a folder of predictions on a test set as it unpacks, whose own lists say which label map is whose.

    Predictions are named as the images are, in their folders or all in one.

    name, root : of the test set, and its folder
    scenes : section of the params that holds its settings, where it has any

    Raises FoggyError as `of_folders` does, or where a list of the test set or a label map is missing.
    """
    test_set, guess = DATASETS[name], find_predictions(predictions)
    labels = dict(test_set.tested(root, _Content(root), scenes))
    where = f"labels: {root}, predictions: {predictions}"
    try:
        pairs = pair(labels, guess)
    except ValueError as error:
        told = str(error).replace("label map", "image")
        raise FoggyError(
            f"{told} ({where}). {test_set.title} has {len(labels)} test images: each needs one prediction with its "
            "relative path, or with its name."
        ) from error
    paths = [(root / labels[image], predictions / prediction) for image, prediction in pairs]
    return summary(count_paths(paths, jobs), "labelIds", predictions_encoding, where)


def of_arrays(
    predictions: Any, labels: Any, predictions_encoding: str | None = None, labels_encoding: str | None = None
) -> dict[str, Any]:
    """Scores of arrays of ids: integers 0 to 255, (H, W), several of them, or (N, H, W).

    Raises ValueError if they are no ids, differ in number or size, the encoding is open or contradicted, or nothing is
    labelled.
    """
    sides = _maps(labels, "labels"), _maps(predictions, "predictions")
    if len(sides[0]) != len(sides[1]):
        raise ValueError(f"labels, predictions: {len(sides[0])} and {len(sides[1])} maps, expected as many of each")
    tally = Tally()
    for number, (known, found) in enumerate(zip(*sides, strict=True)):
        if known.shape != found.shape:
            raise ValueError(f"predictions[{number}]: {found.shape}, but its label map has {known.shape} (H, W)")
        tally.add(known, found, f"labels[{number}]", f"predictions[{number}]")
    try:
        return summary(tally, labels_encoding, predictions_encoding, "arrays")
    except FoggyError as error:
        told = str(error).replace(ASK, "Say which: encoding='trainIds' or encoding='labelIds'.")
        raise ValueError(told.removesuffix(" (arrays)")) from error


def summary(
    tally: Tally,
    labels_asked: str | None,
    predictions_asked: str | None,
    where: str,
    labels_named: str | None = None,
    predictions_named: str | None = None,
) -> dict[str, Any]:
    """Scores of a tally, whose encodings are asked for, told by the ids or stated by file names.

    where : of what, for messages. Raises FoggyError where the encoding is open or contradicted, or nothing is labelled.
    """
    try:
        truth = tally.labels.encoding(labels_asked, labels_named)
        guess = tally.predictions.encoding(predictions_asked, predictions_named)
        scores = summarize(tally.matrix(truth, guess), tally.images)
    except ValueError as error:
        raise FoggyError(f"{error} ({where})") from error
    return {**scores, "encoding": {"labels": truth, "predictions": guess}}


def in_words(scores: Mapping[str, Any]) -> str:
    """Both means of the scores, and of how many images and classes they are."""
    means, annotated = scores["mean_iou"], scores["annotated_classes"]
    return (
        f"{scores['images']} images, mean IoU {means['annotated']:.2f} % over the {annotated} annotated classes, "
        f"{means['as_published']:.2f} % with absent classes as 0 (/19)"
    )


def by_class(scores: Mapping[str, Any]) -> str:
    """IoU in percent by class, a line each; `--` where the class is not annotated.

    >>> print(by_class({"classes": [{"name": "road", "iou": 97.251}, {"name": "train", "iou": None}]}))
    road           97.25
    train             --
    """
    texts = ((each["name"], "--" if each["iou"] is None else f"{each['iou']:.2f}") for each in scores["classes"])
    return "\n".join(f"{name:<14}{text:>6}" for name, text in texts)


def _maps(values: Any, name: str) -> list[np.ndarray]:
    """Maps of ids, uint8 (H, W) each; ValueError where they are anything else."""
    many = (
        [values] if np.ndim(values) == 2 else [*values] if np.ndim(values) == 3 or not hasattr(values, "ndim") else []
    )
    maps = []
    for number, each in enumerate(map(np.asarray, many)):
        if each.ndim != 2 or each.dtype.kind not in "iu" or each.size == 0:
            raise ValueError(f"{name}[{number}]: {each.dtype} {each.shape}, expected integer ids (H, W)")
        if each.min() < 0 or each.max() > 255:
            raise ValueError(f"{name}[{number}]: ids from {each.min()} to {each.max()}, expected 0 to 255")
        maps.append(np.ascontiguousarray(each, np.uint8))
    if not maps:
        raise ValueError(f"{name}: shape {np.shape(values)}, expected ids (H, W), several of them, or (N, H, W)")
    return maps


class _Content(Mapping[str, str]):
    """An index of a folder as it is now: SHA-256 by path below it, computed when it is asked for."""

    def __init__(self, root: Path) -> None:
        self._root = root

    def __getitem__(self, path: str) -> str:
        if path not in self:
            raise KeyError(path)
        return sha256(self._root / path)

    def __contains__(self, path: object) -> bool:
        return isinstance(path, str) and (self._root / path).is_file()

    def __iter__(self) -> Iterator[str]:
        for place, _, names in os.walk(self._root):
            for name in names:
                yield (Path(place) / name).relative_to(self._root).as_posix()

    def __len__(self) -> int:
        return sum(1 for _ in self)
