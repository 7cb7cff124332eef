"""Cityscapes labels: the 34 labelIds of ground truth files and the 19 trainIds of evaluation.

Source: Cords et al., The Cityscapes Dataset, CVPR 2016, and the label table of its public scripts.
"""

from collections.abc import Collection

import numpy as np

IGNORE = 255
"""Value of pixels that count neither in training nor in scores, in trainId maps."""

CLASSES = (
    "road", "sidewalk", "building", "wall", "fence", "pole", "traffic light", "traffic sign", "vegetation", "terrain",
    "sky", "person", "rider", "car", "truck", "bus", "train", "motorcycle", "bicycle",
)  # fmt: skip
"""Names of the 19 evaluation classes, in trainId order."""

LABEL_IDS = (7, 8, 11, 12, 13, 17, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 31, 32, 33)
"""labelId of each evaluation class, in trainId order."""

PALETTE = np.array(
    [
        (128, 64, 128), (244, 35, 232), (70, 70, 70), (102, 102, 156), (190, 153, 153), (153, 153, 153), (250, 170, 30),
        (220, 220, 0), (107, 142, 35), (152, 251, 152), (70, 130, 180), (220, 20, 60), (255, 0, 0), (0, 0, 142),
        (0, 0, 70), (0, 60, 100), (0, 80, 100), (0, 0, 230), (119, 11, 32),
    ],
    dtype=np.uint8,
)  # fmt: skip
"""8-bit RGB of each evaluation class, in trainId order, shape (19, 3)."""

CATEGORIES = {
    "flat": ("road", "sidewalk"),
    "construction": ("building", "wall", "fence"),
    "object": ("pole", "traffic light", "traffic sign"),
    "nature": ("vegetation", "terrain"),
    "sky": ("sky",),
    "human": ("person", "rider"),
    "vehicle": ("car", "truck", "bus", "train", "motorcycle", "bicycle"),
}
"""The seven categories of the evaluation classes."""

# labelIds that exist but are not evaluated; 0 to 33, and 255 for the -1 of licence plates stored in 8 bit.
VOID_IDS = (0, 1, 2, 3, 4, 5, 6, 9, 10, 14, 15, 16, 18, 29, 30, 255)

_TO_TRAIN = np.full(256, -1, dtype=np.int16)
_TO_TRAIN[list(LABEL_IDS)] = np.arange(len(CLASSES))
_TO_TRAIN[list(VOID_IDS)] = IGNORE
_FROM_TRAIN = np.zeros(256, dtype=np.uint8)
_FROM_TRAIN[: len(CLASSES)] = LABEL_IDS


def to_train_ids(label_ids: np.ndarray, name: str) -> np.ndarray:
    """Turn labelIds into trainIds.

    Parameters
    ----------
    label_ids : uint8 (H, W), labelIds 0 to 33; 255 stands for the -1 of licence plates
    name : what to call the map in an error

    Returns
    -------
    uint8 (H, W), trainIds 0 to 18 and 255 for ignored pixels

    Raises
    ------
    ValueError
        If an id is outside the encoding, or the map is one of trainIds by all appearance (see `encoding`).

    >>> to_train_ids(np.array([[7, 23, 4]], dtype=np.uint8), "example").tolist()
    [[0, 10, 255]]
    """
    ids = _ids(label_ids, name)
    unknown = [value for value in ids if _TO_TRAIN[value] < 0]
    if unknown:
        raise ValueError(f"{name}: label {unknown[0]} is no Cityscapes labelId (0 to 33)")
    if encoding(ids) == "trainIds":
        raise ValueError(f"{name}: holds ids {ids} only, which are trainIds where labelIds are expected")
    return _TO_TRAIN[label_ids].astype(np.uint8)


def check_train_ids(train_ids: np.ndarray, name: str) -> np.ndarray:
    """Return a map of trainIds as it is, or raise ValueError as `to_train_ids` does for labelIds."""
    ids = _ids(train_ids, name)
    unknown = [value for value in ids if value >= len(CLASSES) and value != IGNORE]
    if unknown:
        raise ValueError(
            f"{name}: id {unknown[0]} is no trainId (0 to 18, or 255). Are these labelIds where trainIds are expected?"
        )
    return train_ids


def from_train_ids(train_ids: np.ndarray) -> np.ndarray:
    """Turn trainIds into labelIds, uint8 (H, W); ignored pixels become 0 (unlabelled)."""
    return _FROM_TRAIN[train_ids]


def encoding(ids: Collection[int]) -> str:
    """Tell from the values that occur in maps whether they are "labelIds", "trainIds", or "ambiguous".

    Only labelIds go from 19 to 33: vegetation, sky or a car gives them away. Without these, 255
    tells trainIds, and so does road as 0 beside building, vegetation, sky or car as 2, 8, 10 or 13 while 7, the labelId
    of road, is missing.
    The more maps the values come from, the surer the answer.

    >>> encoding([0, 2, 8, 10, 13]), encoding([7, 11, 21, 23]), encoding([0, 7, 8, 11])
    ('trainIds', 'labelIds', 'ambiguous')
    """
    present = set(ids)
    if any(len(CLASSES) <= value != IGNORE for value in present):
        return "labelIds"
    if present - {IGNORE} and (IGNORE in present or (0 in present and 7 not in present and present & {2, 8, 10, 13})):
        return "trainIds"
    return "ambiguous"


def _ids(label_map: np.ndarray, name: str) -> list[int]:
    if label_map.dtype != np.uint8 or label_map.ndim != 2:
        raise ValueError(f"{name}: expected a uint8 map (H, W) of ids, got {label_map.dtype} {label_map.shape}")
    return np.flatnonzero(np.bincount(label_map.ravel(), minlength=256)).tolist()
