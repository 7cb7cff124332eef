"""Counting a test set, image by image or in parts that are added up in any order."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from foggy_synscapes.labels import CLASSES
from foggy_synscapes.scoring.confusion import IDS, JointHistogram, fold, joint_histogram
from foggy_synscapes.scoring.encoding import class_table, contradiction, detect, unknown_ids

ASK = "Say which they are (--encoding trainIds or --encoding labelIds)."


@dataclass
class Side:
    """What is known of all label maps, or of all predictions: enough to tell their encoding and to name culprits.

    `first` maps each id to the first file, by name, that holds it; `alone` maps an encoding to the first file whose
    ids alone tell it.
    """

    what: str
    predicted: bool
    first: dict[int, str] = field(default_factory=dict)
    alone: dict[str, str] = field(default_factory=dict)

    def add(self, ids: Iterable[int], name: str) -> None:
        """Note the ids that one file holds."""
        ids = list(ids)
        _keep_first(self.first, ids, name)
        _keep_first(self.alone, [detect(ids, self.predicted)], name)

    def merge(self, other: "Side") -> None:
        """Note all that another part noted."""
        for mine, theirs in ((self.first, other.first), (self.alone, other.alone)):
            for key, name in theirs.items():
                _keep_first(mine, [key], name)

    def encoding(self, asked: str | None = None, named: str | None = None) -> str:
        """Decide the encoding: what is asked for, or else what the ids tell, or else what the file names say.

        Raises ValueError if the ids leave it open, contradict what is asked for or named, or do not exist.
        """
        if not asked and {"trainIds", "labelIds"} <= self.alone.keys():
            raise ValueError(
                f"{self.what}: {self.alone['trainIds']} holds trainIds, but {self.alone['labelIds']} labelIds. "
                "Score each kind by itself."
            )
        found = asked or detect(self.first, self.predicted)
        if found == "ambiguous" and not named:
            ids = ", ".join(map(str, sorted(self.first)))
            raise ValueError(f"{self.what}: the ids {ids} do not tell whether these are trainIds or labelIds. {ASK}")
        if found == "ambiguous" and named:
            found = named
        if not asked and named and named != found:
            raise ValueError(f"{self.what}: file names say {named}, but the ids are {found}. {ASK}")
        problem = contradiction(found, self.first, self.predicted)
        if problem:
            unknown = unknown_ids(found, self.first)
            where = self.first[unknown[0]] if unknown else self.what
            raise ValueError(f"{where}: {problem}")
        return found


def image_matrix(labels: np.ndarray, predictions: np.ndarray) -> np.ndarray:
    """Confusion matrix of one image, labelIds against predicted trainIds: int64 (19, 20), see `confusion.fold`."""
    counts = joint_histogram(labels, predictions)
    return fold(counts, class_table("labelIds"), class_table("trainIds"), len(CLASSES))


class Tally:
    """Pixels by pair of ids, summed over images; memory does not grow with their number."""

    def __init__(self) -> None:
        self.counts = np.zeros((IDS, IDS), np.int64)
        self.images = 0
        self.labels = Side("labels", predicted=False)
        self.predictions = Side("predictions", predicted=True)
        self._histogram: JointHistogram | None = None

    def __getstate__(self) -> dict[str, Any]:
        # Buffers do not travel between processes.
        return {**self.__dict__, "_histogram": None}

    def add(self, labels: np.ndarray, predictions: np.ndarray, label_name: str, prediction_name: str) -> None:
        """Count one pair of maps, uint8 (H, W); raises ValueError as `confusion.joint_histogram` does."""
        self._histogram = self._histogram or JointHistogram()
        counts = self._histogram(labels, predictions)
        self.labels.add(np.flatnonzero(counts.any(axis=1)).tolist(), label_name)
        self.predictions.add(np.flatnonzero(counts.any(axis=0)).tolist(), prediction_name)
        self.counts += counts
        self.images += 1

    def merge(self, other: "Tally") -> None:
        """Add what another tally counted."""
        self.counts += other.counts
        self.images += other.images
        self.labels.merge(other.labels)
        self.predictions.merge(other.predictions)

    def matrix(self, labels: str, predictions: str) -> np.ndarray:
        """Confusion matrix of the 19 classes, int64 (19, 20), for maps in these encodings; see `confusion.fold`."""
        return fold(self.counts, class_table(labels), class_table(predictions), len(CLASSES))


def _keep_first(first: dict, keys: Iterable, name: str) -> None:
    for key in keys:
        if key not in first or name < first[key]:
            first[key] = name
