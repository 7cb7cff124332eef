"""`foggy export`: the file that is written computes what the model computes, alone and at any size."""

import json
import sys
from pathlib import Path

import numpy as np
import onnx
import pytest
import torch

from foggy_synscapes.cli import main
from foggy_synscapes.io.hashing import sha256
from foggy_synscapes.io.images import encode_png
from foggy_synscapes.io.tables import write_csv
from foggy_synscapes.networks import NetworkConfig
from foggy_synscapes.networks.network import build
from foggy_synscapes.networks.weights import Model, Preprocessing, dump
from foggy_synscapes.tradeoff.graph import Graph, with_paired_stems
from foggy_synscapes.tradeoff.onnx_export import OPSET, Session, to_int8, to_onnx, with_output

ROOT = Path(__file__).resolve().parents[2]
SCALE = 0.75
CONFIGS = {
    "bisenet": NetworkConfig("bisenet", "resnet18", width=8, decoder=8),
    "refinenet": NetworkConfig("refinenet", "resnet18", width=8, decoder=8, auxiliary=False),
}
# Channels in the other order and a scale of their own: nothing of it may be lost on the way.
CAFFE = Preprocessing("BGR", 1.0, (103.939, 116.779, 123.68), (58.0, 57.0, 57.0))


def image(height: int, width: int, seed: int = 0) -> np.ndarray:
    """Smooth colours with some noise: networks see edges, and quantisation a range of values."""
    random = np.random.default_rng(seed)
    coarse = random.integers(0, 256, (-(-height // 16), -(-width // 16), 3)).repeat(16, 0).repeat(16, 1)
    return np.clip(coarse[:height, :width] + random.integers(-20, 20, (height, width, 3)), 0, 255).astype(np.uint8)


def model(name: str, preprocessing: Preprocessing) -> Model:
    """A tiny network with random weights and statistics of batch norm that are not those it begins with."""
    torch.manual_seed(1)
    network = build(CONFIGS[name])
    for layer in network.modules():
        if isinstance(layer, torch.nn.BatchNorm2d):
            layer.running_mean.uniform_(-0.5, 0.5)
            layer.running_var.uniform_(0.5, 2)
            torch.nn.init.uniform_(layer.weight, 0.5, 1.5)
            torch.nn.init.uniform_(layer.bias, -0.5, 0.5)
    return Model(network.eval(), preprocessing)


@pytest.fixture(scope="module")
def models() -> dict[str, Model]:
    return {"bisenet": model("bisenet", CAFFE), "refinenet": model("refinenet", Preprocessing())}


@pytest.fixture(scope="module")
def graph(models: dict[str, Model]) -> bytes:
    """The exporter takes seconds, so it runs once; the trade-off's test takes the other network through it."""
    return to_onnx(models["bisenet"], SCALE)


def eager(model: Model, scale: float, rgb: np.ndarray) -> tuple[torch.Tensor, torch.Tensor]:
    with torch.inference_mode():
        logits, classes = Graph(model, scale)(torch.from_numpy(rgb)[None])
    return logits[0], classes[0]


@pytest.mark.parametrize(("height", "width"), [(64, 96), (33, 70), (1, 1), (171, 128)])
def test_the_graph_gives_what_pytorch_gives_at_any_size(models, graph, height: int, width: int) -> None:
    rgb, session = image(height, width), Session(graph, 1)
    expected = eager(models["bisenet"], SCALE, rgb)[0].numpy()
    assert expected.shape == (19, height, width)
    np.testing.assert_allclose(session(rgb, "logits"), expected, atol=1e-5 * np.abs(expected).max())
    np.testing.assert_array_equal(session(rgb, "classes"), session(rgb, "logits").argmax(axis=0))


def test_at_full_scale_the_module_around_a_network_adds_nothing(models) -> None:
    rgb = image(50, 70)
    logits, classes = eager(models["refinenet"], 1, rgb)
    assert torch.equal(logits, models["refinenet"].logits(rgb))
    np.testing.assert_array_equal(classes.numpy(), models["refinenet"].predict(rgb))


@pytest.mark.parametrize("name", ["bisenet", "refinenet"])
def test_paired_stems_change_the_order_of_sums_only(models, name: str) -> None:
    rgb = image(64, 96)
    expected = models[name].logits(rgb)
    torch.testing.assert_close(with_paired_stems(models[name]).logits(rgb), expected, atol=1e-4, rtol=1e-4)
    assert torch.equal(models[name].logits(rgb), expected), "the model itself must stay as it is"


@pytest.mark.parametrize("scale", [0, -1, 1.5])
def test_impossible_scales_are_refused(models, scale: float) -> None:
    with pytest.raises(ValueError, match=r"expected 0\.01 to 1"):
        Graph(models["bisenet"], scale)


def test_the_file_holds_no_path_and_says_what_it_is(graph) -> None:
    assert str(ROOT).encode() not in graph
    assert b".py" not in graph
    proto = onnx.load_from_string(graph)
    assert [(one.domain, one.version) for one in proto.opset_import] == [("", OPSET)]
    about = json.loads({one.key: one.value for one in proto.metadata_props}["foggy"])
    assert (about["network"]["name"], about["scale"], about["preprocessing"]["channels"]) == ("bisenet", SCALE, "BGR")


def test_a_single_output_needs_less_of_the_graph(graph) -> None:
    whole, logits = (onnx.load_from_string(data) for data in (graph, with_output(graph, "logits")))
    assert [one.name for one in logits.graph.output] == ["logits"]
    assert "ArgMax" in {node.op_type for node in whole.graph.node}
    assert "ArgMax" not in {node.op_type for node in logits.graph.node}


def test_eight_bits_stay_close_and_give_the_same_bytes_again(models, graph) -> None:
    images = [image(64, 96, seed) for seed in range(4)]
    quantised = to_int8(graph, images)
    assert quantised == to_int8(graph, images)
    assert len(quantised) < 0.6 * len(graph)
    expected = eager(models["bisenet"], SCALE, images[0])[0].numpy()
    off = np.abs(Session(quantised, 1)(images[0], "logits") - expected).max()
    assert 0 < off < 0.2 * np.abs(expected).max()


def test_eight_bits_without_images_are_refused(graph) -> None:
    with pytest.raises(ValueError, match="expected at least one to calibrate on"):
        to_int8(graph, [])


@pytest.fixture
def here(models, graph, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a model, a list of images, and the exporter's work done already."""
    monkeypatch.chdir(tmp_path)
    Path("m.safetensors").write_bytes(dump(models["bisenet"].network, models["bisenet"].preprocessing))
    monkeypatch.setattr("foggy_synscapes.tradeoff.onnx_export.to_onnx", lambda model, scale: graph)
    folder = Path("results/scenes/cityscapes")
    folder.mkdir(parents=True)
    rows = []
    for name in ("a.png", "b.png"):
        (folder / name).write_bytes(encode_png(image(64, 96)))
        rows.append((f"cityscapes:{name}", sha256(folder / name)))
    write_csv("list.csv", ("image", "image_sha256"), rows)
    return tmp_path


def export(*options: str) -> int:
    return main(["export", "--params", str(ROOT / "params.yaml"), "--scale", str(SCALE), *options])


def test_the_command_writes_what_it_checked(here: Path, models, capsys) -> None:
    assert export("--model", "m.safetensors", "--out", "m.onnx") == 0
    told = capsys.readouterr()
    assert "bisenet, float32, opset 18, input image, output classes" in told.out
    assert [line for line in told.err.splitlines() if line.startswith("export: ")] == [
        "export: tracing bisenet ...",
        "export: comparing with PyTorch on 2 images ...",
    ]
    rgb = image(40, 60)
    written = Session(Path("m.onnx").read_bytes(), 1)
    np.testing.assert_array_equal(written(rgb, "classes"), eager(models["bisenet"], SCALE, rgb)[1])


def test_the_command_calibrates_on_a_list(here: Path, capsys) -> None:
    call = ("--model", "m.safetensors", "--out", "m.onnx", "--int8", "--calibrate", "list.csv")
    assert export(*call, "--output", "logits") == 0
    said = capsys.readouterr().out
    assert "int8, calibrated on 2 images" in said
    assert "largest logit difference" in said


def test_a_graph_that_computes_something_else_is_not_written(here: Path, models, capsys) -> None:
    other = model("bisenet", Preprocessing())
    Path("m.safetensors").write_bytes(dump(other.network, other.preprocessing))
    assert export("--model", "m.safetensors", "--out", "m.onnx") == 1
    assert "logits of the ONNX graph differ from PyTorch's by" in capsys.readouterr().err
    assert not Path("m.onnx").exists()


@pytest.mark.parametrize(
    ("options", "status", "message"),
    [
        (["--model", "none.safetensors", "--out", "m.onnx"], 1, "none.safetensors: missing"),
        (["--model", "list.csv", "--out", "m.onnx"], 1, "no whole safetensors file"),
        (["--model", "m.safetensors", "--out", "m.tflite"], 2, "expected a name that ends in .onnx"),
        (["--model", "m.safetensors", "--out", "m.onnx", "--format", "tflite"], 2, "invalid choice"),
        (["--model", "m.safetensors", "--out", "m.onnx", "--scale", "2"], 2, "expected 0.01 to 1"),
        (["--model", "m.safetensors", "--out", "m.onnx", "--int8"], 2, "name the images to calibrate on"),
        (["--model", "m.safetensors", "--out", "m.onnx", "--calibrate", "list.csv"], 2, "only --int8"),
        (["--model", "m.safetensors", "--out", "m.onnx", "--int8", "--calibrate", "x.csv"], 1, "x.csv: missing"),
        (["--out", "m.onnx"], 2, "give --model, or"),
        (["--network", "bisenet", "--out", "m.onnx"], 2, "belong together"),
    ],
)
def test_bad_calls_say_what_is_wrong(here: Path, capsys, options: list[str], status: int, message: str) -> None:
    assert export(*options) == status
    assert message in capsys.readouterr().err
    assert not Path("m.onnx").exists()


def test_missing_packages_are_named_with_what_to_do(here: Path, monkeypatch, capsys) -> None:
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    assert export("--model", "m.safetensors", "--out", "m.onnx") == 1
    assert "pip install foggy-synscapes[export]" in capsys.readouterr().err
