"""evaluate: anyone's predictions through the command line, trained models on test sets, and every bad input."""

import json
import struct
import subprocess
import sys
import zlib
from pathlib import Path

import numpy as np
import pytest
from ids import put, random_ids, score

from foggy_synscapes.cli import main
from foggy_synscapes.datasets import foggy_driving
from foggy_synscapes.io.atomic import write_bytes, write_text
from foggy_synscapes.io.images import encode_png
from foggy_synscapes.labels import CLASSES, from_train_ids
from foggy_synscapes.scoring.confusion import confusion_matrix
from foggy_synscapes.scoring.metrics import summarize

ROOT = Path(__file__).resolve().parents[2]
FRAMES = ("aachen/aachen_000000_000019", "ulm/ulm_000001_000019", "ulm/ulm_000002_000019")


@pytest.fixture
def folders(tmp_path: Path) -> Path:
    """labels/ as gtFine has them (labelIds), predictions/ in trainIds under the names of the images."""
    for number, frame in enumerate(FRAMES):
        put(tmp_path / f"labels/{frame}_gtFine_labelIds.png", from_train_ids(random_ids(number)))
        put(tmp_path / f"predictions/{frame}_leftImg8bit.png", random_ids(number + 10, void=False))
    return tmp_path


def refused(folder: Path, capsys: pytest.CaptureFixture, *options: str) -> str:
    """The message of a scoring that must fail and leave nothing behind."""
    status, scores = score(folder, *options)
    assert (status, scores) == (1, None)
    message = capsys.readouterr().err
    assert message.startswith("foggy evaluate: ")
    assert "Traceback" not in message
    return message


def expected(frames=range(3)) -> dict:
    matrix = sum(confusion_matrix(random_ids(n), random_ids(n + 10, void=False), 19) for n in frames)
    return summarize(matrix, len(frames))


def test_scores_a_folder_of_predictions(folders, capsys):
    status, scores = score(folders)
    assert status == 0
    assert scores.pop("encoding") == {"labels": "labelIds", "predictions": "trainIds"}
    assert scores == expected()
    said = capsys.readouterr().out
    assert "labels read as labelIds, predictions as trainIds; 3 images" in said
    assert "over the 19 annotated classes" in said


def test_metrics_have_the_form_that_others_rely_on(folders):
    _, scores = score(folders)
    assert [entry["name"] for entry in scores["classes"]] == list(CLASSES)
    assert set(scores["classes"][0]) == {"name", "iou", "tp", "fp", "fn"}
    assert set(scores["mean_iou"]) == {"annotated", "as_published"}
    assert (scores["annotated_classes"], scores["images"]) == (19, 3)
    assert np.array(scores["confusion"]).shape == (19, 19)


def test_iou_of_each_class_is_printed_and_no_file_is_needed(folders, capsys, monkeypatch):
    monkeypatch.chdir(folders)
    assert main(["evaluate", "--predictions", "predictions", "--labels", "labels"]) == 0
    said = capsys.readouterr().out.splitlines()
    wanted = [f"{each['name']:<14}{each['iou']:>6.2f}" for each in expected()["classes"]]
    assert said[-19:] == wanted
    assert sorted(path.name for path in folders.iterdir()) == ["labels", "predictions"]


def driving(root: Path) -> list[tuple[str, str, np.ndarray]]:
    """Foggy Driving as it unpacks, with other maps beside the labels: image, label map and trainIds of each frame."""
    found = []
    for number, (name, coarse) in enumerate((("web/web_a", False), ("public/public_b", True), ("web/web_c", True))):
        image, label, ids = foggy_driving.image(name, coarse), foggy_driving.labels(name, coarse), random_ids(number)
        put(root / image, np.zeros((*ids.shape, 3), np.uint8))
        put(root / label, from_train_ids(ids))
        put(root / label.replace("labelIds", "color"), np.zeros((*ids.shape, 3), np.uint8))
        found.append((image, label, ids))
    for path, column in ((foggy_driving.IMAGES, 0), (foggy_driving.LABELS, 1)):
        write_text(root / path, "".join(f"{frame[column]}\n" for frame in found))
    return found


@pytest.mark.parametrize("naming", ["as the images", "flat", "as the labels"])
def test_predictions_on_a_test_set_are_scored_by_its_own_folder(tmp_path, monkeypatch, capsys, naming):
    """Fine and coarse labels lie apart there, and the images beside them."""
    monkeypatch.chdir(tmp_path)
    for number, (image, label, _) in enumerate(driving(tmp_path / "Foggy_Driving")):
        name = {"as the images": image, "flat": Path(image).name, "as the labels": label}[naming]
        put(tmp_path / "predictions" / name, random_ids(number + 10, void=False))
    call = ["evaluate", "--test-set", "foggy_driving", "--labels", "Foggy_Driving", "--predictions", "predictions"]
    assert main([*call, "--out", "metrics.json"]) == 0
    scores = json.loads(Path("metrics.json").read_text())
    assert scores.pop("encoding") == {"labels": "labelIds", "predictions": "trainIds"}
    assert scores == expected()
    assert "person" in capsys.readouterr().out


def test_a_prediction_that_a_test_set_lacks_is_named(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    frames = driving(tmp_path / "Foggy_Driving")
    for image, _, ids in frames[:2]:
        put(tmp_path / "predictions" / image, ids)
    call = ["evaluate", "--test-set", "foggy_driving", "--labels", "Foggy_Driving", "--predictions", "predictions"]
    assert main(call) == 1
    said = capsys.readouterr().err
    assert "1 of 3 images without a prediction: leftImg8bit/test_extra/web/web_c_leftImg8bit.png" in said
    assert "Foggy Driving has 3 test images" in said


def test_number_of_processes_does_not_matter(tmp_path):
    for number in range(30):
        put(tmp_path / f"labels/{number}.png", random_ids(number))
        put(tmp_path / f"predictions/{number}.png", random_ids(number + 100, void=False))
    files = []
    for jobs in ("1", "2", "7"):
        assert score(tmp_path, "--jobs", jobs)[0] == 0
        files.append((tmp_path / "metrics.json").read_bytes())
    assert files[0] == files[1] == files[2]


def test_flat_predictions_in_label_ids(folders):
    for number, frame in enumerate(FRAMES):
        (folders / f"predictions/{frame}_leftImg8bit.png").unlink()
        put(folders / f"predictions/{Path(frame).name}.png", from_train_ids(random_ids(number + 10, void=False)))
    _, scores = score(folders)
    assert scores.pop("encoding") == {"labels": "labelIds", "predictions": "labelIds"}
    assert scores == expected()


def test_other_maps_of_cityscapes_are_left_out_and_said(folders, capsys):
    write_bytes(folders / f"labels/{FRAMES[0]}_gtFine_color.png", b"not even looked at")
    write_bytes(folders / f"labels/{FRAMES[0]}_gtFine_instanceIds.png", b"")
    write_text(folders / f"labels/{FRAMES[0]}_gtFine_polygons.json", "{}")
    assert score(folders)[1]["images"] == 3
    assert "2 files are not maps of the ids asked for and are left out" in capsys.readouterr().out


def test_label_ids_beside_train_ids_must_be_chosen(folders, capsys):
    for number, frame in enumerate(FRAMES):
        put(folders / f"labels/{frame}_gtFine_labelTrainIds.png", random_ids(number))
    assert "--labels-encoding" in refused(folders, capsys)
    for choice in ("labelIds", "trainIds"):
        _, scores = score(folders, "--labels-encoding", choice)
        assert scores.pop("encoding")["labels"] == choice
        assert scores == expected()


def test_absent_class_is_null_in_json(tmp_path):
    labels = random_ids(0)
    labels[labels == 16] = 15
    put(tmp_path / "labels/a.png", labels)
    put(tmp_path / "predictions/a.png", random_ids(1, void=False))
    _, scores = score(tmp_path)
    assert scores["classes"][16]["iou"] is None
    assert scores["classes"][16]["fp"] > 0
    assert scores["annotated_classes"] == 18
    assert scores["mean_iou"]["as_published"] == pytest.approx(scores["mean_iou"]["annotated"] * 18 / 19)


def test_missing_prediction_is_an_error(folders, capsys):
    (folders / f"predictions/{FRAMES[1]}_leftImg8bit.png").unlink()
    message = refused(folders, capsys)
    assert f"1 of 3 label maps without a prediction: {FRAMES[1]}_gtFine_labelIds.png" in message


def test_extra_prediction_is_an_error(folders, capsys):
    put(folders / "predictions/more.png", random_ids(0))
    assert "1 of 4 predictions without a label map: more.png" in refused(folders, capsys)


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_other_size_is_an_error_never_a_resize(folders, capsys, jobs):
    put(folders / f"predictions/{FRAMES[2]}_leftImg8bit.png", random_ids(0, (6, 10)))
    message = refused(folders, capsys, "--jobs", jobs)
    assert f"{FRAMES[2]}_leftImg8bit.png: 6 x 10, but its label map" in message
    assert "12 x 20" in message


def test_rgb_instead_of_ids_is_an_error(folders, capsys):
    write_bytes(folders / f"predictions/{FRAMES[0]}_leftImg8bit.png", encode_png(np.zeros((12, 20, 3), np.uint8)))
    assert "8-bit RGB, expected 8-bit grey. Is this the colour preview?" in refused(folders, capsys)


def test_16_bit_ids_are_an_error(folders, capsys):
    write_bytes(folders / f"labels/{FRAMES[0]}_gtFine_labelIds.png", encode_png(np.zeros((12, 20), np.uint16)))
    assert "16-bit grey, expected 8-bit grey" in refused(folders, capsys)


def test_a_palette_is_an_error(folders, capsys):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", 20, 12, 8, 3, 0, 0, 0)
    pixels = zlib.compress(b"".join(b"\0" + bytes(20) for _ in range(12)))
    chunks = [chunk(b"IHDR", header), chunk(b"PLTE", bytes(57)), chunk(b"IDAT", pixels), chunk(b"IEND", b"")]
    write_bytes(folders / f"predictions/{FRAMES[0]}_leftImg8bit.png", b"\x89PNG\r\n\x1a\n" + b"".join(chunks))
    assert "palette, expected 8-bit grey" in refused(folders, capsys)


def test_a_damaged_file_is_an_error_that_names_it(folders, capsys):
    path = folders / f"predictions/{FRAMES[1]}_leftImg8bit.png"
    write_bytes(path, path.read_bytes()[:-20])
    assert f"{FRAMES[1]}_leftImg8bit.png: cut off" in refused(folders, capsys)


def test_unknown_id_is_an_error_that_names_file_and_id(folders, capsys):
    ids = random_ids(0, void=False)
    ids[3, 4] = 77
    put(folders / f"predictions/{FRAMES[1]}_leftImg8bit.png", ids)
    message = refused(folders, capsys, "--predictions-encoding", "trainIds")
    assert f"{FRAMES[1]}_leftImg8bit.png: id 77 does not exist in trainIds" in message
    assert refused(folders, capsys)  # and no guess either


def test_the_wrong_encoding_is_refused(folders, capsys):
    message = refused(folders, capsys, "--encoding", "trainIds")
    assert "does not exist in trainIds" in message
    assert "--labels-encoding and --predictions-encoding tell them apart" in message
    assert "look like trainIds" in refused(folders, capsys, "--predictions-encoding", "labelIds")


def test_an_open_encoding_is_refused_until_it_is_said(tmp_path, capsys):
    for side in ("labels", "predictions"):
        put(tmp_path / f"{side}/a.png", np.array([[7, 8, 11, 13]], np.uint8))
    message = refused(tmp_path, capsys)
    assert "labels: the ids 7, 8, 11, 13 do not tell whether these are trainIds or labelIds" in message
    status, scores = score(tmp_path, "--encoding", "labelIds")
    assert (status, scores["classes"][0]["iou"], scores["annotated_classes"]) == (0, 100.0, 4)
    assert scores["classes"][4]["name"] == "fence"
    _, scores = score(tmp_path, "--encoding", "trainIds")
    assert [entry["name"] for entry in scores["classes"] if entry["iou"]] == [CLASSES[n] for n in (7, 8, 11, 13)]


def test_a_set_in_which_nothing_is_annotated_is_an_error(tmp_path, capsys):
    put(tmp_path / "labels/a.png", np.full((4, 4), 255, np.uint8))
    put(tmp_path / "predictions/a.png", random_ids(0, (4, 4), void=False))
    assert "no pixel of the ground truth is labelled" in refused(tmp_path, capsys, "--encoding", "trainIds")


@pytest.mark.parametrize("side", ["labels", "predictions"])
def test_empty_or_missing_folder_is_an_error(folders, capsys, side):
    for path in (folders / side).rglob("*.png"):
        path.unlink()
    assert f"{side}: holds no PNG file" in refused(folders, capsys)
    (folders / side).rename(folders / "elsewhere")
    assert f"{side}: no such folder" in refused(folders, capsys)


def test_images_of_another_format_are_an_error(folders, capsys):
    write_bytes(folders / "predictions/a.jpg", b"x")
    assert "a.jpg is no PNG file" in refused(folders, capsys)


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["--predictions", "p"],
        ["--network", "bisenet", "--row", "C"],
        ["--network", "bisenet", "--row", "C", "--seed", "0", "--test-set", "cityscapes", "--labels", "x"],
        ["--predictions", "p", "--labels", "l", "--out", "o", "--jobs", "0"],
        ["--predictions", "p", "--labels", "l", "--out", "o", "--encoding", "colours"],
        ["--predictions", "p", "--labels", "l", "--network", "bisenet"],
        ["--predictions", "p", "--test-set", "foggy_driving"],
        ["--predictions", "p", "--labels", "l", "--test-set", "synscapes"],
        ["--predictions", "p", "--labels", "l", "--test-set", "foggy_driving", "--labels-encoding", "trainIds"],
    ],
)
def test_a_wrong_call_ends_with_status_2(arguments, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["evaluate", *arguments]) == 2
    assert "Traceback" not in capsys.readouterr().err


def test_scoring_a_folder_needs_no_torch():
    code = "import sys; from foggy_synscapes.stages import evaluate, tables; sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
