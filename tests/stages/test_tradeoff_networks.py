"""tradeoff of networks: every way is timed and scored on a test set, and the words follow from the figures."""

import sys
from pathlib import Path

import numpy as np
import pytest
import torch
import yaml
from records import index_of, vouch
from training_project import frame, project_in, write_list, write_lists

from foggy_synscapes.cli import main
from foggy_synscapes.datasets.index import write_index
from foggy_synscapes.io.atomic import write_bytes
from foggy_synscapes.io.images import encode_png
from foggy_synscapes.io.tables import read_csv
from foggy_synscapes.networks import NetworkConfig
from foggy_synscapes.networks.network import build
from foggy_synscapes.networks.weights import Model, Preprocessing, dump, load_model
from foggy_synscapes.tradeoff import training
from foggy_synscapes.tradeoff.networks import (
    BACKENDS,
    BFLOAT16,
    EAGER,
    INT8,
    ONNX,
    WAYS,
    Score,
    bars,
    measure,
    paragraph,
    pareto_front,
    recommended,
    table,
)

MODEL = Path("results/train/refinenet/FS-24500/seed-0/model.safetensors")


def score(way: str, cpu_ms: float, right: int, scale: float = 1.0, images: int = 10) -> Score:
    """A way that gets `right` of 100 pixels of road right and calls the others sidewalk."""
    matrices = np.zeros((images, 19, 20), np.int64)
    matrices[:, 0, 0] = right + np.arange(images) % 2  # some images are a little easier
    matrices[:, 0, 1] = 100 - matrices[:, 0, 0]
    return Score("bisenet", scale, way, cpu_ms, matrices, largest=0.5, changed=2.0)


def test_the_front_weighs_time_against_mean_iou() -> None:
    scores = [
        score(EAGER, 10, 80),
        score(ONNX, 5, 80),
        score(INT8, 2, 79),
        score(INT8, 3, 70, 0.5),
    ]
    assert pareto_front(scores) == [False, True, True, False]


def test_the_fastest_way_that_loses_little_is_recommended() -> None:
    plain = score(EAGER, 10, 80)
    others = [score(ONNX, 5, 80), score(INT8, 2, 79)]
    assert recommended([plain, *others], "bisenet", 0.5).way == ONNX
    assert recommended([plain, *others], "bisenet", 1.5).way == INT8
    text = paragraph([plain, *others], 0.5)
    assert "Take **ONNX float32** at scale 1: 5.0 ms, 2.0 times as fast, 0.00 points" in text
    assert "no difference at all. It is the fastest that surely loses at most 0.5 points." in text
    assert "ONNX int8 at scale 1 is 5.0 times as fast at -1.00 points: loses 1.00 to 1.00 points." in text
    assert text.endswith("`export`: PyTorch bfloat16.")
    assert "surely within 0.5 points of that: take **PyTorch float32**" in paragraph([plain, others[1]], 0.5)


def test_an_uncertain_way_is_not_recommended_though_its_mean_is_good() -> None:
    plain, unsteady = score(EAGER, 10, 80), score(INT8, 2, 80)
    unsteady.matrices[::2, 0, :2] = 60, 40
    unsteady.matrices[1::2, 0, :2] = 100, 0
    assert abs(unsteady.miou - plain.miou) < 0.6
    assert recommended([plain, unsteady], "bisenet", 0.7) is plain


def test_bars_lie_around_the_reference_and_not_around_each_value() -> None:
    plain, other = score(EAGER, 10, 80), score(INT8, 2, 79)
    assert bars([plain, other])[0] is None
    np.testing.assert_allclose(bars([plain, other])[1], (plain.miou - 1, plain.miou - 1))


def test_of_a_test_set_of_one_image_nothing_is_recommended() -> None:
    plain, other = score(EAGER, 10, 80, images=1), score(ONNX, 5, 80, images=1)
    assert recommended([plain, other], "bisenet", 0.5) is plain
    assert "Of one image there is no interval, so nothing is recommended" in paragraph([plain, other], 0.5)
    line = table([plain, other], [True, True]).iloc[0]
    assert (line["low"], line["high"]) == ("--", "--")


def test_what_was_not_measured_prints_dashes() -> None:
    measured = [score(EAGER, 10, 80), score(EAGER, 5, 60, 0.5)]
    lines = table(measured, [True, True])[list(BACKENDS)].itertuples(index=False, name=None)
    found = {line[1:3]: line[3:] for line in lines}
    assert list(found) == [(scale, way) for scale in ("1", "0.5") for way in WAYS]
    assert found["1", EAGER][:7] == ("10.0", "1.00", "80.50", "0.00", "0.00", "0.00", "")
    assert found["0.5", EAGER][:7] == ("5.0", "2.00", "60.50", "-20.00", "-20.00", "-20.00", "road -20.0")
    assert found["1", INT8] == (*["--"] * 9, "")


def test_without_the_packages_pytorch_is_measured_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "onnx", None)
    model = Model(build(NetworkConfig("bisenet", "resnet18", 8, 4)).eval(), Preprocessing())
    image, labels = frame(0)
    found = measure("bisenet", model, [(image, labels)], [image], [1.0])
    assert found[0].way == EAGER
    assert {one.way for one in found} <= {EAGER, BFLOAT16}
    assert (found[0].largest, found[0].changed) == (0, 0)


def test_training_time_is_counted_up_from_measured_iterations() -> None:
    few, many = (
        training.Cost("bisenet", "few", 100, 50, 1.2, 30.0),
        training.Cost("bisenet", "many", 900, 500, 1.2, 31.5),
    )
    assert few.minutes == pytest.approx(1.0)
    text = training.paragraph([many, few])
    expected = (
        "BiSeNet: many (900 images) takes 10.0 times as long as few (100); mean IoU changes by +1.50 points, of one "
    )
    expected += "seed and without an interval."
    assert text == expected


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two test images, a model, and lists to calibrate on and to train on."""
    project_in(tmp_path, monkeypatch)
    write_lists("FS-24500")
    write_list("FS-498", "train", write_lists("FS-498")[:2])
    document = yaml.safe_load(Path("params.yaml").read_text())
    document["train"]["networks"] = ["refinenet"]
    document["tradeoff"] |= {"row": "FS-24500", "test_set": "cityscapes", "scales": [1.0], "calibration": 2, "steps": 1}
    Path("params.yaml").write_text(yaml.safe_dump(document, sort_keys=False))
    root, names = Path("results/scenes/cityscapes"), []
    for number in range(2):
        for kind, ending, pixels in zip(
            ("leftImg8bit", "gtFine"), ("leftImg8bit", "gtFine_labelIds"), frame(number), strict=True
        ):
            names.append(f"{kind}/val/town/town_00000{number}_000019_{ending}.png")
            write_bytes(root / names[-1], encode_png(pixels))
    write_index(index_of("cityscapes"), root, names)
    torch.manual_seed(0)
    network = build(NetworkConfig("refinenet", "resnet18", 8, 4, auxiliary=False))
    write_bytes(MODEL, dump(network, Preprocessing()))
    vouch()
    return tmp_path


def expected_miou() -> float:
    """Mean IoU of the model over the four classes of the frames, counted by hand."""
    model = load_model(MODEL.read_bytes())
    frames = [frame(number) for number in range(2)]
    guess = np.stack([model.predict(image) for image, _ in frames])
    truth = np.stack([labels for _, labels in frames])
    pairs = {7: 0, 11: 2, 23: 10, 26: 13}
    shares = [
        ((guess == ours) & (truth == theirs)).sum() / ((guess == ours) | (truth == theirs)).sum()
        for theirs, ours in pairs.items()
    ]
    return 100 * float(np.mean(shares))


def test_table_plot_and_text_are_written(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["tradeoff", "--part", "networks"]) == 0, capsys.readouterr().err
    found = {row["way"]: row for row in read_csv("results/tradeoff/networks.csv")}
    assert list(found) == list(WAYS)
    assert found[EAGER]["changed_percent"] == "0"
    assert float(found[ONNX]["largest_logit_change"]) < 1e-3
    assert float(found[INT8]["largest_logit_change"]) > float(found[ONNX]["largest_logit_change"])
    assert float(found[ONNX]["cpu_ms"]) > 0
    assert found[EAGER]["miou"] == f"{expected_miou():.2f}"
    costs = read_csv("results/tradeoff/training.csv")
    assert [(row["row"], row["images"], row["miou"]) for row in costs] == [
        ("FS-24500", "4", "--"),
        ("FS-498", "2", "--"),
    ]
    assert "RefineNet: PyTorch in float32 takes" in Path("results/tradeoff/networks.md").read_text()
    for ending, start in (("png", b"\x89PNG"), ("pdf", b"%PDF"), ("tex", b"% Needs")):
        assert Path(f"results/tradeoff/networks.{ending}").read_bytes().startswith(start)
    assert main(["verify", "results/tradeoff"]) == 0


@pytest.fixture
def quick(project: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The same where ONNX is not installed: exporting takes most of the time."""
    monkeypatch.setitem(sys.modules, "onnx", None)
    return project


def change(**values: object) -> None:
    document = yaml.safe_load(Path("params.yaml").read_text())
    document["tradeoff"] |= values
    Path("params.yaml").write_text(yaml.safe_dump(document, sort_keys=False))


def test_no_more_images_are_measured_than_are_allowed_for(quick: Path) -> None:
    change(images=1)
    assert main(["tradeoff", "--part", "networks"]) == 0
    text = Path("results/tradeoff/networks.md").read_text()
    assert "on 1 of 2 stand-in images" in text
    assert "Of one image there is no interval, so nothing is recommended" in text


def test_a_time_that_is_too_short_for_an_image_is_named(quick: Path, capsys: pytest.CaptureFixture[str]) -> None:
    change(minutes=1e-9)
    assert main(["tradeoff", "--part", "networks"]) == 1
    assert "tradeoff.minutes: 1e-09 is too short for a single image" in capsys.readouterr().err


def test_a_row_without_a_length_of_its_own_is_timed_by_the_baselines(quick: Path) -> None:
    document = yaml.safe_load(Path("params.yaml").read_text())
    train = document["train"]
    train["from_weights"].append("FS-24500")
    train["from_baseline"].remove("FS-24500")
    train["rows"]["FS-24500"] = None
    train["refinenet"]["baseline"]["length"] = {"iterations": 3}
    Path("params.yaml").write_text(yaml.safe_dump(document, sort_keys=False))
    assert main(["tradeoff", "--part", "networks"]) == 0
    costs = {row["row"]: row["iterations"] for row in read_csv("results/tradeoff/training.csv")}
    assert costs["FS-24500"] == "3"


def test_a_model_that_was_not_trained_is_asked_for(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    MODEL.unlink()
    assert main(["tradeoff", "--part", "networks"]) == 1
    assert f"{MODEL}: missing" in capsys.readouterr().err
    assert not Path("results/tradeoff").exists()


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("row", "FC-9", "tradeoff.row: FC-9 is no row of train"),
        ("scales", [0.5, 1.0], "scales: 1.0 first"),
        ("scales", [1.0, 2.0], "less than or equal to 1"),
        ("calibration", 0, "greater than or equal to 1"),
        ("images", 0, "greater than or equal to 1"),
        ("minutes", 0, "greater than 0"),
        ("tolerance", 0, "greater than 0"),
    ],
)
def test_params_that_cannot_be_are_refused(project: Path, capsys, key: str, value: object, message: str) -> None:
    document = yaml.safe_load(Path("params.yaml").read_text())
    document["tradeoff"][key] = value
    Path("params.yaml").write_text(yaml.safe_dump(document))
    assert main(["tradeoff", "--part", "networks"]) == 1
    assert message in capsys.readouterr().err
