"""evaluate: trained models on test sets, as jobs of the pipeline, and every bad input."""

import json
from pathlib import Path

import numpy as np
import pytest
from ids import put, random_ids, score
from records import index_of, vouch

from foggy_synscapes.cli import main
from foggy_synscapes.datasets import foggy_driving, foggy_zurich
from foggy_synscapes.datasets.index import write_index
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.atomic import write_bytes, write_text
from foggy_synscapes.io.images import read_ids
from foggy_synscapes.io.plain_yaml import read_yaml
from foggy_synscapes.io.shards import Shard
from foggy_synscapes.labels import from_train_ids
from foggy_synscapes.params import check
from foggy_synscapes.stages.evaluate import evaluate

ROOT = Path(__file__).resolve().parents[2]


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


def test_a_test_set_of_the_params_needs_no_folder(params, capsys):
    """Its root and its settings, such as which of two lists, come from the params."""
    write_text(Path("params.yaml"), json.dumps(params.model_dump(mode="json", by_alias=True)))
    for number, frame in enumerate((3, 1, 2)):
        shape = (32 + 7 * number, 48)
        put(Path("predictions") / f"{frame}.0_frame.png", random_ids(number, shape, void=False))
    assert main(["evaluate", "--test-set", "foggy_zurich", "--predictions", "predictions"]) == 0
    assert "3 images, mean IoU 100.00 %" in capsys.readouterr().out
