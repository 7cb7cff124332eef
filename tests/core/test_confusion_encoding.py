"""The encoding of maps is told from their ids, or asked for; files are paired by name, one to one."""

import pytest

from foggy_synscapes.scoring.encoding import class_table, contradiction, detect
from foggy_synscapes.scoring.pairing import frame, is_other_map, named_encoding, pair
from foggy_synscapes.scoring.tally import Side


@pytest.mark.parametrize(
    ("ids", "predicted", "expected"),
    [
        ([7, 8, 11, 21, 23, 26], True, "labelIds"),
        ([0, 1, 4, 7, 23], False, "labelIds"),
        ([0, 7, 23], True, "labelIds"),  # 0 as "unlabelled" among predictions
        (list(range(19)), True, "trainIds"),  # nobody predicts an ego vehicle or a rail track
        ([0, 1, 255], False, "trainIds"),
        ([0, 10, 255], True, "trainIds"),
        ([0, 2, 8, 10, 13], False, "trainIds"),
        (list(range(19)), False, "ambiguous"),
        ([7, 8, 11], True, "ambiguous"),
        ([0, 7, 8], False, "ambiguous"),
        ([255], False, "ambiguous"),
        ([1, 2, 3, 20], True, "ambiguous"),  # trainIds with one stray id, or labelIds with stray voids?
        ([0, 1, 20, 255], False, "ambiguous"),
    ],
)
def test_ids_tell_the_encoding(ids, predicted, expected):
    assert detect(ids, predicted) == expected


@pytest.mark.parametrize(
    ("name", "ids", "predicted", "message"),
    [
        ("trainIds", [0, 26], False, "id 26 does not exist in trainIds"),
        ("trainIds", [19, 254], True, "id 19, 254 does not exist in trainIds"),
        ("labelIds", [7, 34], False, "id 34 does not exist in labelIds"),
        ("labelIds", [0, 1, 255], False, "look like trainIds"),
        ("labelIds", [0, 1, 2, 3, 7], True, "look like trainIds"),
        ("labelIds", [0, 1, 2, 3, 7], False, None),
        ("labelIds", [1, 2, 3, 23], True, None),
        ("labelIds", [7, 26, 255], False, None),  # 255 is how 8 bits store the -1 of a licence plate
        ("trainIds", [7, 8, 11], True, None),
    ],
)
def test_what_is_asked_for_must_be_possible(name, ids, predicted, message):
    found = contradiction(name, ids, predicted)
    assert found is None if message is None else message in found


def test_unknown_encoding_is_an_error():
    with pytest.raises(ValueError, match="encoding: 'colours'"):
        class_table("colours")


def side(*files, predicted=False):
    made = Side("labels", predicted)
    for number, ids in enumerate(files):
        made.add(ids, f"{number}.png")
    return made


def test_all_files_together_tell_what_one_leaves_open():
    assert side([7, 8], [7, 11], [7, 23]).encoding() == "labelIds"


def test_open_encoding_is_refused_and_says_how_to_answer():
    with pytest.raises(ValueError, match=r"the ids 7, 8, 11 do not tell .*--encoding trainIds or --encoding labelIds"):
        side([7, 8], [11]).encoding()
    assert side([7, 8], [11]).encoding(asked="labelIds") == "labelIds"
    assert side([7, 8], [11]).encoding(named="trainIds") == "trainIds"


def test_file_names_that_contradict_the_ids_are_refused():
    with pytest.raises(ValueError, match="file names say trainIds, but the ids are labelIds"):
        side([7, 23]).encoding(named="trainIds")


def test_a_mixture_of_encodings_is_refused():
    with pytest.raises(ValueError, match=r"1\.png holds trainIds, but 0\.png labelIds"):
        side([7, 23], [0, 1, 255]).encoding()


def test_an_unknown_id_names_its_file():
    with pytest.raises(ValueError, match=r"^1\.png: id 40 does not exist in labelIds"):
        side([7, 23], [7, 40]).encoding(asked="labelIds")


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("frankfurt/frankfurt_000000_000294_leftImg8bit.png", "frankfurt/frankfurt_000000_000294"),
        ("frankfurt/frankfurt_000000_000294_gtFine_labelIds.png", "frankfurt/frankfurt_000000_000294"),
        ("a_000000_000001_gtCoarse_labelTrainIds.png", "a_000000_000001"),
        ("a_000000_000001_leftImg8bit_foggy_beta_0.01.png", "a_000000_000001"),
        ("GP010229/1508040913.0_frame_000955.png", "GP010229/1508040913.0_frame_000955"),
        ("GOPR0475_frame_000247_rgb_anon.png", "GOPR0475_frame_000247"),
        ("GOPR0475_frame_000247_gt_labelTrainIds.png", "GOPR0475_frame_000247"),
        ("_labelIds.png", "_labelIds"),
    ],
)
def test_frame_is_what_files_of_a_scene_share(name, expected):
    assert frame(name) == expected


def test_names_state_encoding_and_kind():
    assert named_encoding("a_gtFine_labelIds.png") == "labelIds"
    assert named_encoding("a_gt_labelTrainIds.png") == named_encoding("a_trainIds.png") == "trainIds"
    assert named_encoding("labelIds/a.png") is None
    assert is_other_map("a_gtFine_color.png")
    assert is_other_map("a_gtFine_instanceIds.png")


def test_same_paths_are_paired_even_where_names_repeat():
    names = ["a/1.png", "b/1.png"]
    assert pair(names, names) == [("a/1.png", "a/1.png"), ("b/1.png", "b/1.png")]


def test_flat_predictions_are_paired_by_unique_names():
    labels = ["x/x_1_gtFine_labelIds.png", "y/y_2_gtFine_labelIds.png"]
    assert pair(labels, ["y_2_leftImg8bit.png", "x_1_leftImg8bit.png"]) == [
        ("x/x_1_gtFine_labelIds.png", "x_1_leftImg8bit.png"),
        ("y/y_2_gtFine_labelIds.png", "y_2_leftImg8bit.png"),
    ]


@pytest.mark.parametrize(
    ("labels", "predictions", "message"),
    [
        (["a.png", "b.png"], ["a.png"], "1 of 2 label maps without a prediction: b.png"),
        (["a.png"], ["a.png", "z/c.png"], "1 of 2 predictions without a label map: z/c.png"),
        (["a.png"], ["b.png"], "a.png; 1 of 1 predictions without a label map: b.png"),
        (["a/1.png", "b/1.png"], ["1.png"], "2 of 2 label maps without a prediction"),
        (["a_gtFine_labelIds.png"], ["a.png", "a_pred.png"], "2 predictions for one frame: a.png, a_pred.png"),
        (["a.png", "a_labelIds.png"], ["a.png"], "2 label maps for one frame"),
        ([f"{n}.png" for n in range(9)], [], "0.png, 1.png, 2.png and 6 more"),
    ],
)
def test_files_without_counterpart_are_named(labels, predictions, message):
    with pytest.raises(ValueError, match=r"label map|prediction") as error:
        pair(labels, predictions)
    assert message in str(error.value)
