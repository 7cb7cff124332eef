"""What `foggy train` is given and cannot learn from ends with one message that names it, and leaves nothing behind."""

import io
import json
import pickle
from pathlib import Path

import numpy as np
import pytest
import safetensors.torch
import torch
from PIL import Image
from training_project import frame, project_in, train, write_list, write_lists

from foggy_synscapes.io.hashing import sha256_bytes
from foggy_synscapes.networks import NetworkConfig
from foggy_synscapes.networks.network import build
from foggy_synscapes.networks.weights import Preprocessing, dump, read_tensors


@pytest.fixture
def project(tmp_path, monkeypatch):
    """A project to train in; gives a function that changes its params."""
    return project_in(tmp_path, monkeypatch)


def refused(capsys, *parts):
    assert train() == 1
    message = capsys.readouterr().err
    # Beside the lines that tell how far the training is.
    assert len([line for line in message.splitlines() if not line.startswith("train ")]) == 1
    for part in parts:
        assert part in message
    assert not list(Path("results/train").rglob("*"))


def png(image):
    buffer = io.BytesIO()
    image.save(buffer, "PNG")
    return buffer.getvalue()


RGB = frame(0)[0]


@pytest.mark.parametrize(
    ("image", "kind"),
    [
        (Image.fromarray(RGB).convert("RGBA"), "8-bit RGB with alpha"),
        (Image.fromarray(RGB[..., 0]), "8-bit grey"),
        (Image.fromarray(RGB[..., 0].astype(np.uint16)), "16-bit grey"),
    ],
    ids=["alpha", "grey", "16 bit"],
)
def test_an_image_that_is_not_8_bit_rgb_is_named(project, capsys, image, kind):
    entries, data = write_lists("C"), png(image)
    Path("results/scenes/cityscapes/image_0.png").write_bytes(data)
    entries[0][1] = sha256_bytes(data)
    write_list("C", "train", entries[:4])
    refused(capsys, "cityscapes:image_0.png", f"{kind}, expected 8-bit RGB")


def test_an_unknown_id_is_found_late_in_a_list_that_is_not_kept_in_memory(project, capsys):
    project(("cache",), 0)
    project(("bisenet", "baseline", "length"), {"iterations": 20})
    project(("snapshot",), 100)
    entries = write_lists("C", count=14)
    pixels = frame(9)[1]
    pixels[0, 0] = 200
    data = png(Image.fromarray(pixels))
    Path("results/scenes/cityscapes/label_9.png").write_bytes(data)
    entries[9][3] = sha256_bytes(data)
    write_list("C", "train", entries[:12])
    write_list("C", "validation", entries[12:])
    refused(capsys, "cityscapes:label_9.png", "200")


def model(name="bisenet", classes=19):
    network = build(NetworkConfig(name, "resnet18", width=8, decoder=4, classes=classes, auxiliary=name == "bisenet"))
    return dump(network, Preprocessing())


def with_extra_keys():
    data = model()
    about, tensors = read_tensors(data, "foggy")

    return safetensors.torch.save({**tensors, "head.extra": torch.zeros(2)}, {"foggy": json.dumps(about)})


class Trap:
    """Pickled, it makes a file when it is loaded."""

    def __reduce__(self):
        return Path.touch, (Path("it ran"),)


@pytest.mark.parametrize(
    ("weights", "message"),
    [
        (lambda: model("refinenet"), "weights of another network: name refinenet, wanted bisenet"),
        (lambda: model(classes=21), "weights of another network: classes 21, wanted 19"),
        (lambda: model()[:5000], "no whole safetensors file"),
        (with_extra_keys, "1 left over ['head.extra']"),
        (lambda: pickle.dumps({"weight": Trap()}), "no whole safetensors file"),
    ],
    ids=["other network", "other class count", "truncated", "extra keys", "pickle"],
)
def test_start_weights_that_do_not_fit_are_refused_and_run_nothing(project, capsys, weights, message):
    Path("start.safetensors").write_bytes(weights())
    project(("bisenet", "weights"), "start.safetensors")
    refused(capsys, "start.safetensors: ", message)
    assert not Path("it ran").exists()


def test_the_trap_of_the_test_above_would_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert pickle.loads(pickle.dumps({"weight": Trap()})) == {"weight": None}
    assert Path("it ran").exists()
