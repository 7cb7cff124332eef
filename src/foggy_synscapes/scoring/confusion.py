"""Confusion matrices from maps of ids, exact in int64.

Two maps are first counted as they are, id against id (`joint_histogram`). That count is all that any score
needs: counts of images, shards and processes are added in any order, and the encoding of either map can
still be found from the sum (see `encoding`) before it is folded to classes (`fold`).
"""

import numpy as np

IDS = 256
WORD = 8  # flags in a 64-bit word
CHUNK = 1 << 19  # pixels, whole words: bounds the memory of the buffers
VOID = -1  # in a table of `fold`: the id is valid and belongs to no class
UNKNOWN = -2  # in a table of `fold`: the id does not exist in the encoding


class JointHistogram:
    """Counts how often each pair of ids occurs at a pixel of two maps; keeps its buffers from one pair to the next.

    On maps of 2 million pixels, fresh buffers would cost as much time as the counting itself.

    chunk : pixels that are counted at once, a multiple of WORD
    """

    def __init__(self, chunk: int = CHUNK) -> None:
        self._counts = np.zeros(IDS * IDS, np.int64)
        self._ends = np.zeros(chunk, bool)
        self._other = np.empty(chunk, bool)

    def __call__(self, labels: np.ndarray, predictions: np.ndarray) -> np.ndarray:
        """Count one pair of maps; as `joint_histogram`, but the array is overwritten by the next call."""
        for name, array in (("labels", labels), ("predictions", predictions)):
            if array.dtype != np.uint8:
                raise ValueError(f"{name}: {array.dtype} values, expected ids in uint8")
        if labels.shape != predictions.shape:
            raise ValueError(f"predictions: shape {predictions.shape}, but the labels have {labels.shape}")
        flat_labels, flat_predictions = labels.reshape(-1), predictions.reshape(-1)
        self._counts.fill(0)
        for start in range(0, flat_labels.size, self._ends.size):
            part = slice(start, start + self._ends.size)
            self._count(flat_labels[part], flat_predictions[part])
        return self._counts.reshape(IDS, IDS)

    def _count(self, labels: np.ndarray, predictions: np.ndarray) -> None:
        # Maps of things consist of long runs of one pair: finding where runs end is much cheaper than looking at each
        # pixel. `ends` marks the last pixel of each run; few of its words of eight flags have any.
        between = labels.size - 1
        ends = self._ends[: -(-labels.size // WORD) * WORD]
        other = self._other[:between]
        np.not_equal(labels[1:], labels[:-1], out=ends[:between])
        np.not_equal(predictions[1:], predictions[:-1], out=other)
        ends[:between] |= other
        ends[between] = True
        ends[labels.size :] = False
        words = ends.view(np.uint64)
        busy = np.flatnonzero(words != 0)
        if busy.size * 4 > words.size:
            # A noisy map, in which runs are short, is counted pixel by pixel.
            self._counts += np.bincount(_pairs(labels, predictions), minlength=self._counts.size)
            return
        flags = np.flatnonzero(words[busy].view(bool))
        last = busy[flags // WORD] * WORD + flags % WORD
        np.add.at(self._counts, _pairs(labels[last], predictions[last]), np.diff(last, prepend=-1))


def joint_histogram(labels: np.ndarray, predictions: np.ndarray) -> np.ndarray:
    """Count how often each pair of ids occurs at a pixel: int64 (256, 256), by label (row) and prediction.

    labels, predictions : ids in any encoding, uint8 of one shape; ValueError if they are not. Sums over images are
    plain sums of these counts.

    >>> counts = joint_histogram(np.array([[7, 7, 8]], np.uint8), np.array([[7, 8, 8]], np.uint8))
    >>> int(counts[7, 7]), int(counts[7, 8]), int(counts[8, 8]), int(counts.sum())
    (1, 1, 1, 3)
    """
    return JointHistogram()(labels, predictions)


def _pairs(labels: np.ndarray, predictions: np.ndarray) -> np.ndarray:
    pairs = labels.astype(np.intp)
    pairs *= IDS
    pairs += predictions
    return pairs


def fold(counts: np.ndarray, label_classes: np.ndarray, predicted_classes: np.ndarray, classes: int) -> np.ndarray:
    """Turn counts of ids into a confusion matrix of classes: int64 (C, C + 1).

    counts : int64 (256, 256), from `joint_histogram`, or a sum of such
    label_classes, predicted_classes : int (256,), class of each id, or VOID, or UNKNOWN
    classes : number of classes, C

    Pixels whose label is a class, by that class (row) and predicted class (column). The last column counts predictions
    of no class: they are misses of the labelled class, and false alarms of none. Pixels with a void label are left out,
    whatever is predicted there. Raises ValueError if an id occurs that does not exist in its encoding.
    """
    for name, table, occurs in (
        ("labels", label_classes, counts.any(axis=1)),
        ("predictions", predicted_classes, counts.any(axis=0)),
    ):
        unknown = np.flatnonzero(occurs & (table == UNKNOWN))
        if unknown.size:
            raise ValueError(f"{name}: unknown id {', '.join(map(str, unknown))}")
    matrix = np.zeros((classes, classes + 1), np.int64)
    rows = np.flatnonzero(label_classes >= 0)
    columns = np.where(predicted_classes >= 0, predicted_classes, classes)
    np.add.at(matrix, (label_classes[rows, None], columns[None, :]), counts[rows])
    return matrix


def confusion_matrix(labels: np.ndarray, predictions: np.ndarray, classes: int, ignore: int = 255) -> np.ndarray:
    """Confusion matrix of two maps of class indices 0 to `classes` - 1 and `ignore`; see `fold`.

    >>> truth, guess = np.array([[0, 0, 1, 255]], np.uint8), np.array([[0, 1, 1, 0]], np.uint8)
    >>> confusion_matrix(truth, guess, classes=2).tolist()
    [[1, 1, 0], [0, 1, 0]]
    """
    table = index_table(classes, ignore)
    return fold(joint_histogram(labels, predictions), table, table, classes)


def index_table(classes: int, ignore: int) -> np.ndarray:
    """Table for `fold` of an encoding in which ids are class indices and `ignore` is void: int64 (256,)."""
    table = np.full(IDS, UNKNOWN, np.int64)
    table[:classes] = np.arange(classes)
    table[ignore] = VOID
    return table
