"""Which encoding a set of maps is in, and what its ids mean.

The same numbers name other classes in labelIds and trainIds: 7 is the road or a traffic sign. Maps read in the
wrong one give a plausible table of nonsense, so that nothing is guessed here: either the ids that occur
decide, or the caller is asked.
"""

from collections.abc import Collection

import numpy as np

from foggy_synscapes.datasets.labels import CLASSES, IGNORE, LABEL_IDS, VOID_IDS, encoding
from foggy_synscapes.scoring.confusion import IDS, UNKNOWN, VOID, index_table

ENCODINGS = ("trainIds", "labelIds")

# labelIds that no scorer counts, below those that only labelIds have. 0, unlabelled, is left out: it is the
# road in trainIds, but a network may also be made to predict it.
_NEVER_PREDICTED = frozenset(range(1, len(CLASSES))) - set(LABEL_IDS)
_SURE = 3  # that many different ones in predictions cannot be labelIds, whoever says so


def class_table(name: str) -> np.ndarray:
    """Class of each id of an encoding, for `confusion.fold`: int64 (256,).

    Examples
    --------
    >>> class_table("labelIds")[[7, 23, 4, 34]].tolist(), class_table("trainIds")[[7, 255]].tolist()
    ([0, 10, -1, -2], [7, -1])
    """
    if name not in ENCODINGS:
        raise ValueError(f"encoding: {name!r}, expected one of {', '.join(ENCODINGS)}")
    if name == "trainIds":
        return index_table(len(CLASSES), IGNORE)
    table = np.full(IDS, UNKNOWN, np.int64)
    table[list(VOID_IDS)] = VOID
    table[list(LABEL_IDS)] = np.arange(len(CLASSES))
    return table


def detect(ids: Collection[int], predicted: bool) -> str:
    """Tell the encoding of maps from the ids that occur in them: "trainIds", "labelIds" or "ambiguous".

    Beyond what gives label maps away (see `datasets.labels.encoding`), predictions cannot be labelIds where
    they hold ids such as 2 or 10 and none from 19 on: as labelIds these are a rectification border and a rail
    track, which nobody predicts.

    Examples
    --------
    >>> detect([1, 8, 11], predicted=True), detect([1, 8, 11], predicted=False), detect([7, 8], predicted=True)
    ('trainIds', 'ambiguous', 'ambiguous')
    """
    found = encoding(ids)
    if found == "ambiguous" and predicted and _NEVER_PREDICTED & set(ids):
        return "trainIds"
    return found


def contradiction(name: str, ids: Collection[int], predicted: bool) -> str | None:
    """Say why maps with these ids cannot be in the encoding `name`, or return None where they can."""
    present = set(ids)
    table = class_table(name)
    unknown = sorted(value for value in present if table[value] == UNKNOWN)
    if unknown:
        return f"id {', '.join(map(str, unknown))} does not exist in {name}"
    if name == "trainIds" or any(len(CLASSES) <= value < IGNORE for value in present):
        return None
    if IGNORE in present and len(present) > 1:
        return f"{IGNORE} beside ids below {len(CLASSES)} only: these look like trainIds"
    odd = sorted(_NEVER_PREDICTED & present)
    if predicted and len(odd) >= _SURE:
        few = ", ".join(map(str, odd[:_SURE]))
        return f"ids such as {few} and none from {len(CLASSES)} on: these look like trainIds"
    return None
