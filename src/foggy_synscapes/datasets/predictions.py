"""Any folder of predictions beside any folder of label maps: which PNG files there are and which belong together."""

import os
from collections.abc import Iterable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.images import read_ids
from foggy_synscapes.io.processes import in_processes
from foggy_synscapes.io.progress import progress
from foggy_synscapes.scoring.pairing import is_other_map, named_encoding, pair
from foggy_synscapes.scoring.tally import Tally

BATCH = 8  # images that a process counts before it reports

_IMAGES = (".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".npy", ".npz", ".webp", ".gif")


@dataclass(frozen=True)
class Pairs:
    """(label, prediction) paths below their folders, sorted; the encodings that file names state; files passed over."""

    pairs: list[tuple[str, str]]
    labels_named: str | None
    predictions_named: str | None
    other_maps: int


def find_pairs(labels: Path, predictions: Path, wanted: str | None = None) -> Pairs:
    """Find and pair all PNG files below two folders.

    Where label maps lie among the other files of Cityscapes (`_color`, `_instanceIds`), these are passed over and
    counted; where both `_labelIds` and `_labelTrainIds` are there, `wanted` says which to take.

    Raises
    ------
    FoggyError
        If a folder is missing or empty, holds images of another kind, or a file stays without its counterpart.
    """
    truth, guess = _png_files(labels, "label maps"), _png_files(predictions, "predictions")
    maps = [name for name in truth if named_encoding(name)] or truth
    kinds = {named_encoding(name) for name in maps}
    if len(kinds) == 2:
        if wanted is None:
            raise FoggyError(
                f"{labels}: holds label maps named labelIds and others named labelTrainIds. "
                "Say which to score against (--labels-encoding labelIds or trainIds)."
            )
        maps, kinds = [name for name in maps if named_encoding(name) == wanted], {wanted}
    if len(maps) < len(truth):
        strays = [name for name in truth if not named_encoding(name) and not is_other_map(name)]
        if strays:
            raise FoggyError(f"{labels}: {strays[0]} lies among label maps, but its name does not say that it is one")
    stated = {named_encoding(name) for name in guess}
    try:
        pairs = pair(maps, guess)
    except ValueError as error:
        raise FoggyError(
            f"{error} (labels: {labels}, predictions: {predictions}). "
            "Each label map needs one prediction with the same relative path, or the same unique name."
        ) from error
    return Pairs(pairs, kinds.pop(), stated.pop() if len(stated) == 1 else None, len(truth) - len(maps))


def find_predictions(folder: Path) -> list[str]:
    """Paths of all PNG files below a folder of predictions, sorted; FoggyError as `find_pairs` raises it."""
    return _png_files(folder, "predictions")


def count_pairs(labels: Path, predictions: Path, pairs: list[tuple[str, str]], jobs: int) -> Tally:
    """Count all pairs in `jobs` processes: the result does not depend on their number, nor memory on the images'.

    Raises
    ------
    FoggyError
        If a file is damaged or no 8-bit grey PNG, or a prediction differs in size from its label map.
    """
    return count_paths([(labels / label, predictions / prediction) for label, prediction in pairs], jobs)


def count_paths(pairs: list[tuple[Path, Path]], jobs: int) -> Tally:
    """The same of pairs of files, label map and prediction, wherever they lie."""
    tally = Tally()
    batches = [pairs[start : start + BATCH] for start in range(0, len(pairs), BATCH)]
    parts = in_processes(_count, batches, min(jobs, len(batches)), lambda batch: f"{batch[0][0]} and next ones")
    with closing(parts):
        for part in progress(parts, "evaluate", total=len(batches), unit=f"x {BATCH} images"):
            tally.merge(part)
    return tally


def _count(pairs: Iterable[tuple[Path, Path]]) -> Tally:
    tally = Tally()
    for label, prediction in pairs:
        truth, guess = read_ids(label), read_ids(prediction)
        if truth.shape != guess.shape:
            raise FoggyError(
                f"{prediction}: {_size(guess)}, but its label map {label} has {_size(truth)} "
                "(rows x columns). Predictions are scored at the size of the labels, never resized."
            )
        tally.add(truth, guess, str(label), str(prediction))
    return tally


def _size(array: np.ndarray) -> str:
    return " x ".join(map(str, array.shape))


def _png_files(folder: Path, what: str) -> list[str]:
    if not folder.is_dir():
        raise FoggyError(f"{folder}: no such folder of {what}")
    found, others = [], []
    seen: dict[str, str] = {}
    for place, _, names in os.walk(folder, followlinks=True):
        if (other := seen.setdefault(os.path.realpath(place), place)) != place:  # links may lead back, without end
            raise FoggyError(f"{place}: is the same folder as {other}. Remove the link to it.")
        for name in names:
            relative = (Path(place) / name).relative_to(folder).as_posix()
            if name.startswith("."):
                continue
            if name.lower().endswith(".png"):
                found.append(relative)
            elif name.lower().endswith(_IMAGES):
                others.append(relative)
    if others:
        raise FoggyError(f"{folder}: {min(others)} is no PNG file. Only 8-bit grey PNG maps of ids are scored.")
    if not found:
        raise FoggyError(f"{folder}: holds no PNG file, expected {what}")
    return sorted(found)
