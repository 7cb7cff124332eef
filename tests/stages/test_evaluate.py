"""evaluate: anyone's predictions through the command line, trained models on test sets, and every bad input."""

import json
import struct
import subprocess
import sys
import zlib
from pathlib import Path

import numpy as np
import pytest
from records import index_of, vouch

from foggy_synscapes.cli import main
from foggy_synscapes.datasets import foggy_driving, foggy_zurich
from foggy_synscapes.datasets.index import write_index
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.atomic import write_bytes, write_text
from foggy_synscapes.io.images import encode_png, read_ids
from foggy_synscapes.io.plain_yaml import read_yaml
from foggy_synscapes.io.shards import Shard
from foggy_synscapes.labels import CLASSES, from_train_ids
from foggy_synscapes.params import check
from foggy_synscapes.scoring.confusion import confusion_matrix
from foggy_synscapes.scoring.metrics import summarize
from foggy_synscapes.stages.evaluate import evaluate

ROOT = Path(__file__).resolve().parents[2]
FRAMES = ("aachen/aachen_000000_000019", "ulm/ulm_000001_000019", "ulm/ulm_000002_000019")


def random_ids(seed: int, shape: tuple[int, int] = (12, 20), void: bool = True) -> np.ndarray:
    """trainIds of all classes, with some ignored pixels."""
    rng = np.random.default_rng(seed)
    ids = rng.integers(0, 19, shape).astype(np.uint8)
    if void:
        ids[0] = 255
    return ids


def put(path: Path, ids: np.ndarray) -> None:
    write_bytes(path, encode_png(ids))


@pytest.fixture
def folders(tmp_path: Path) -> Path:
    """labels/ as gtFine has them (labelIds), predictions/ in trainIds under the names of the images."""
    for number, frame in enumerate(FRAMES):
        put(tmp_path / f"labels/{frame}_gtFine_labelIds.png", from_train_ids(random_ids(number)))
        put(tmp_path / f"predictions/{frame}_leftImg8bit.png", random_ids(number + 10, void=False))
    return tmp_path


def score(folder: Path, *options: str) -> tuple[int, dict | None]:
    out = folder / "metrics.json"
    out.unlink(missing_ok=True)
    paths = ["--predictions", str(folder / "predictions"), "--labels", str(folder / "labels"), "--out", str(out)]
    status = main(["evaluate", *paths, *options])
    return status, json.loads(out.read_text()) if out.exists() else None


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


def test_a_test_set_of_the_params_needs_no_folder(params, capsys):
    """Its root and its settings, such as which of two lists, come from the params."""
    write_text(Path("params.yaml"), json.dumps(params.model_dump(mode="json", by_alias=True)))
    for number, frame in enumerate((3, 1, 2)):
        shape = (32 + 7 * number, 48)
        put(Path("predictions") / f"{frame}.0_frame.png", random_ids(number, shape, void=False))
    assert main(["evaluate", "--test-set", "foggy_zurich", "--predictions", "predictions"]) == 0
    assert "3 images, mean IoU 100.00 %" in capsys.readouterr().out


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


def model_of(classes: int) -> bytes:
    import torch

    from foggy_synscapes.networks.config import NetworkConfig
    from foggy_synscapes.networks.network import build
    from foggy_synscapes.networks.weights import Preprocessing, dump

    torch.manual_seed(0)
    return dump(build(NetworkConfig("bisenet", "resnet18", width=8, decoder=4, classes=classes)), Preprocessing())


@pytest.fixture(scope="module")
def model() -> bytes:
    return model_of(classes=19)


@pytest.fixture
def params(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, model: bytes):
    """Three test images of different sizes in each of two layouts, and a model that has learnt nothing."""
    monkeypatch.chdir(tmp_path)
    document = read_yaml(ROOT / "params.yaml")
    for dataset in document["scenes"]["roots"]:
        document["scenes"]["roots"][dataset] = str(tmp_path / dataset)
    zurich = [(foggy_zurich.image(f"GP/{n}.0_frame"), foggy_zurich.labels(f"GP/{n}.0_frame")) for n in (3, 1, 2)]
    driving = [(foggy_driving.image("web/a", False), foggy_driving.labels("web/a", False))]
    driving += [(foggy_driving.image("public/b", True), foggy_driving.labels("public/b", True))]
    lists = {
        "foggy_zurich": [foggy_zurich.list_path("RGB"), foggy_zurich.list_path("gt_labelIds")],
        "foggy_driving": [foggy_driving.IMAGES, foggy_driving.LABELS],
    }
    for dataset, pairs in (("foggy_zurich", zurich), ("foggy_driving", driving)):
        rng = np.random.default_rng(0)
        for number, (image, label) in enumerate(pairs):
            shape = (32 + 7 * number, 48)
            put(Path(dataset) / image, rng.integers(0, 256, (*shape, 3)).astype(np.uint8))
            put(Path(dataset) / label, from_train_ids(random_ids(number, shape)))
        for column, path in enumerate(lists[dataset]):
            write_text(Path(dataset) / path, "".join(f"{pair[column]}\n" for pair in pairs))
        write_index(index_of(dataset), Path(dataset), [path for pair in pairs for path in pair] + lists[dataset])
    write_bytes(Path("results/train/bisenet/C/seed-0/model.safetensors"), model)
    vouch()
    return check(document, "params.yaml")


@pytest.mark.parametrize("test_set", ["foggy_zurich", "foggy_driving"])
def test_scores_a_model_on_a_test_set(params, test_set, tmp_path):
    evaluate(params, "bisenet", "C", "0", test_set)
    folder = Path("results/evaluate") / test_set / "bisenet/C/seed-0"
    scores = json.loads((folder / "metrics.json").read_text())
    with Shard(folder / "predictions.tar") as shard:
        names = shard.names()
        assert names == sorted(names)
        assert len(names) == scores["images"] == (3 if test_set == "foggy_zurich" else 2)
        for name in names:
            put(tmp_path / "unpacked/predictions" / name, read_ids(shard.read(name)))
    # Unpacked and scored as anyone's predictions they give the same.
    labels = tmp_path / "unpacked/labels"
    (tmp_path / test_set / "gt_labelIds" if test_set == "foggy_zurich" else tmp_path / test_set).rename(labels)
    if test_set == "foggy_driving":
        (labels / "leftImg8bit").rename(tmp_path / "images")
    status, again = score(tmp_path / "unpacked", "--encoding", "labelIds", "--predictions-encoding", "trainIds")
    assert status == 0
    assert again == scores
    record = json.loads((folder / "run.json").read_text())
    assert set(record["inputs"]) == {
        "results/train/bisenet/C/seed-0/model.safetensors",
        f"results/scenes/index/{test_set}/all.csv",
    }
    assert str(tmp_path) not in (folder / "run.json").read_text()


def test_a_job_of_the_pipeline_through_the_command_line(params, capsys):
    write_text(Path("my params.yaml"), json.dumps(params.model_dump(mode="json", by_alias=True)))
    job = ["--network", "bisenet", "--row", "C", "--seed", "0", "--test-set", "foggy_zurich"]
    assert main(["evaluate", *job, "--params", "my params.yaml"]) == 0
    assert "evaluate bisenet C seed 0 on foggy_zurich: 3 images, mean IoU" in capsys.readouterr().out


def test_the_same_model_gives_the_same_bytes(params):
    folder, names = (
        Path("results/evaluate/foggy_zurich/bisenet/C/seed-0"),
        ("metrics.json", "predictions.tar", "run.json"),
    )
    evaluate(params, "bisenet", "C", "0", "foggy_zurich")
    first = [(folder / name).read_bytes() for name in names]
    evaluate(params, "bisenet", "C", "0", "foggy_zurich")
    assert [(folder / name).read_bytes() for name in names] == first


def with_(params, **values):
    return params.model_copy(update={"evaluate": params.evaluate.model_copy(update=values)})


def test_images_that_threads_read_ahead_give_the_same_bytes(params, capsys):
    evaluate(params, "bisenet", "C", "0", "foggy_zurich")
    folder = Path("results/evaluate/foggy_zurich/bisenet/C/seed-0")
    first = {path.name: path.read_bytes() for path in folder.iterdir()}
    evaluate(with_(params, workers=2, device="auto"), "bisenet", "C", "0", "foggy_zurich")
    assert (folder / "predictions.tar").read_bytes() == first["predictions.tar"]
    assert (folder / "metrics.json").read_bytes() == first["metrics.json"]
    assert "waited for images" in capsys.readouterr().out


def test_an_image_that_a_gpu_has_no_memory_for_is_named_with_the_setting(params, monkeypatch):
    import torch

    from foggy_synscapes.networks.weights import Model

    def fail(*_arguments):
        raise torch.OutOfMemoryError("CUDA out of memory. Tried to allocate 2 GiB")

    monkeypatch.setattr(Model, "predict", fail)
    fails(params, r"_frame.*png: not enough memory on the GPU for 39 x 48 pixels. Set evaluate.device to cpu")


def test_a_gpu_that_is_not_there_is_named(params):
    import torch

    if torch.cuda.is_available():
        pytest.skip("there is a GPU")
    fails(with_(params, device="cuda"), "device: cuda, but PyTorch .* finds no GPU")


def fails(params, message: str) -> None:
    with pytest.raises(FoggyError, match=message):
        evaluate(params, "bisenet", "C", "0", "foggy_zurich")
    assert not Path("results/evaluate/foggy_zurich/bisenet/C/seed-0/metrics.json").exists()
    assert not Path("results/evaluate/foggy_zurich/bisenet/C/seed-0/predictions.tar").exists()


def test_a_missing_model_says_how_to_make_it(params):
    Path("results/train/bisenet/C/seed-0/model.safetensors").unlink()
    fails(params, r"model\.safetensors: missing\. Train it first: foggy train --network bisenet --row C --seed 0")


def test_a_damaged_model_is_named(params):
    path = Path("results/train/bisenet/C/seed-0/model.safetensors")
    path.write_bytes(path.read_bytes()[:100])
    vouch(path)
    fails(params, r"model\.safetensors: .*safetensors file")


def test_a_model_of_other_classes_is_refused(params):
    write_bytes(Path("results/train/bisenet/C/seed-0/model.safetensors"), model_of(classes=21))
    vouch()
    fails(params, "predicts 21 classes, expected the 19 of Cityscapes")


def test_a_changed_image_is_named(params):
    put(Path("foggy_zurich") / foggy_zurich.image("GP/1.0_frame"), np.zeros((32, 48, 3), np.uint8))
    fails(params, r"GP/1\.0_frame\.png: its content changed since it was listed")


def test_labels_of_another_size_are_named(params):
    relist(params, np.zeros((5, 5), np.uint8))
    fails(params, r"gt_labelIds/GP/1\.0_frame\.png: predictions: shape")


def test_train_ids_in_place_of_label_ids_are_refused(params):
    for number, name in enumerate(("3", "1", "2")):
        relist(params, random_ids(number, (32 + 7 * number, 48)), name)
    fails(params, r"its label maps hold trainIds where labelIds are expected")


def relist(params, ids: np.ndarray, name: str = "1") -> None:
    put(Path("foggy_zurich") / foggy_zurich.labels(f"GP/{name}.0_frame"), ids)
    files = [path.relative_to("foggy_zurich").as_posix() for path in Path("foggy_zurich").rglob("*") if path.is_file()]
    write_index(index_of("foggy_zurich"), Path("foggy_zurich"), files)
    vouch()


def test_scoring_a_folder_needs_no_torch():
    code = "import sys; from foggy_synscapes.stages import evaluate, tables; sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
