"""Which encoding a set of maps is in, and what its ids mean.

The same numbers name other classes in labelIds and trainIds: 7 is the road or a traffic sign. Maps read in the wrong
one give a plausible table of nonsense, so that nothing is guessed here: either the ids that occur decide, or the
caller is asked.
"""

from collections.abc import Collection

import numpy as np

from foggy_synscapes.labels import CLASSES, IGNORE, LABEL_IDS, VOID_IDS, encoding
from foggy_synscapes.scoring.confusion import IDS, UNKNOWN, VOID, index_table

ENCODINGS = ("trainIds", "labelIds")

# labelIds below 19 that no scorer counts. 0, unlabelled, is left out: a network may be made to predict it.
_NEVER_PREDICTED = frozenset(range(1, len(CLASSES))) - set(LABEL_IDS)
_SURE = 3  # that many different ones in predictions cannot be labelIds, whoever says so


def class_table(name: str) -> np.ndarray:
    """Class of each id of an encoding, for `confusion.fold`: int64 (256,).

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

    Only labelIds go from 19 to 33. Only trainIds hold 255 in what programs write, and predictions in labelIds never
    hold such as 2 or 10, a rectification border and a rail track. Evidence for both is as ambiguous as none.

    >>> [detect(ids, predicted=True) for ids in ([1, 8, 11], [7, 8, 11, 23], [1, 8, 11, 23])]
    ['trainIds', 'labelIds', 'ambiguous']
    >>> [detect(ids, predicted=False) for ids in ([1, 8, 11], [0, 8, 255], [1, 8, 11, 23])]
    ['ambiguous', 'trainIds', 'labelIds']
    """
    present = set(ids)
    odd = IGNORE in present or (predicted and bool(_NEVER_PREDICTED & present))
    if _only_label_ids(present):
        return "ambiguous" if odd else "labelIds"
    return "trainIds" if odd and present != {IGNORE} else encoding(present)


def contradiction(name: str, ids: Collection[int], predicted: bool) -> str | None:
    """Say why maps with these ids cannot be in the encoding `name`, or return None where they can.

    >>> contradiction("trainIds", [0, 1, 33], predicted=True)
    'id 33 does not exist in trainIds'
    """
    present = set(ids)
    unknown = unknown_ids(name, present)
    if unknown:
        return f"id {', '.join(map(str, unknown))} does not exist in {name}"
    if name == "trainIds" or _only_label_ids(present):
        return None
    if IGNORE in present and len(present) > 1:
        return f"{IGNORE} beside ids below {len(CLASSES)} only: these look like trainIds"
    odd = sorted(_NEVER_PREDICTED & present)
    if predicted and len(odd) >= _SURE:
        few = ", ".join(map(str, odd[:_SURE]))
        return f"ids such as {few} and none from {len(CLASSES)} on: these look like trainIds"
    return None


def unknown_ids(name: str, ids: Collection[int]) -> list[int]:
    """Ids that do not exist in an encoding, sorted."""
    table = class_table(name)
    return sorted(value for value in set(ids) if table[value] == UNKNOWN)


def _only_label_ids(present: set[int]) -> bool:
    return any(len(CLASSES) <= value < IGNORE for value in present)
