"""Label encodings: labelIds become trainIds, and the one is not taken for the other."""

import numpy as np
import pytest
from cityscapesscripts.helpers.labels import labels as official

from foggy_synscapes import labels


def test_the_tables_are_those_of_the_cityscapes_scripts() -> None:
    classes = sorted((entry for entry in official if 0 <= entry.trainId < 255), key=lambda entry: entry.trainId)
    assert tuple(entry.name for entry in classes) == labels.CLASSES
    assert tuple(entry.id for entry in classes) == labels.LABEL_IDS
    assert [tuple(colour) for colour in labels.PALETTE] == [entry.color for entry in classes]
    for category, names in labels.CATEGORIES.items():
        assert names == tuple(entry.name for entry in classes if entry.category == category)
    assert {entry.id for entry in official if entry.trainId in (-1, 255)} == {*labels.VOID_IDS} - {255} | {-1}


def test_every_label_id_becomes_its_train_id_and_back() -> None:
    ids = np.arange(34, dtype=np.uint8)[None]
    expected = [entry.trainId for entry in sorted(official, key=lambda entry: entry.id) if entry.id >= 0]
    train = labels.to_train_ids(ids, "all")
    assert train[0].tolist() == expected
    assert labels.from_train_ids(train)[train != 255].tolist() == list(labels.LABEL_IDS)


@pytest.mark.parametrize("value", [34, 99, 200, 254])
def test_an_id_outside_the_encoding_is_named(value: int) -> None:
    with pytest.raises(ValueError, match=f"a.png: label {value} is no Cityscapes labelId"):
        labels.to_train_ids(np.full((2, 2), value, dtype=np.uint8), "a.png")


def test_train_ids_where_label_ids_are_expected_are_refused_and_the_reverse() -> None:
    with pytest.raises(ValueError, match="trainIds where labelIds are expected"):
        labels.to_train_ids(np.array([[0, 2, 8, 10, 13, 255]], dtype=np.uint8), "a.png")
    with pytest.raises(ValueError, match="id 21 is no trainId"):
        labels.check_train_ids(np.array([[7, 11, 21, 23]], dtype=np.uint8), "a.png")


@pytest.mark.parametrize("array", [np.zeros((2, 2, 3), np.uint8), np.zeros((2, 2), np.uint16)])
def test_what_is_no_map_of_ids_is_refused(array: np.ndarray) -> None:
    with pytest.raises(ValueError, match="expected a uint8 map"):
        labels.to_train_ids(array, "a.png")
