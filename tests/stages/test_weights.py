"""`foggy weights import`: files of every kind, read without running what is in them."""

import pickle
import re
from pathlib import Path

import h5py
import numpy as np
import pytest
import safetensors.torch
import torch

from foggy_synscapes import params
from foggy_synscapes.cli import main
from foggy_synscapes.networks import NetworkConfig
from foggy_synscapes.networks.layouts import layouts
from foggy_synscapes.networks.network import build
from foggy_synscapes.networks.weights import load_model

SMALL = {
    "bisenet": NetworkConfig("bisenet", "resnet18", width=8, decoder=4),
    "refinenet": NetworkConfig("refinenet", "resnet50", width=8, decoder=4, auxiliary=False),
}


def public(layout, network="bisenet"):
    """A network's tensors under the names of a layout, and the network."""
    torch.manual_seed(0)
    module = build(SMALL[network]).eval()
    translate = layouts()[layout].translate
    return {translate(name, module.config): tensor for name, tensor in module.state_dict().items()}, module


def test_the_documented_commands_make_every_file_that_the_params_start_from():
    root = Path(__file__).resolve().parents[2]
    command = re.compile(r"^foggy weights import (\S+) --network (\S+) --out (\S+)$", re.MULTILINE)
    made = {out: network for _, network, out in command.findall((root / "docs/real-data.md").read_text())}
    needed = {}
    for name in ("paper.yaml", "discussion_full.yaml", "refinenet_baseline.yaml"):
        train = params.load(root / "params" / name).train
        needed |= {train.weights(network, row): network for network in train.networks for row in train.from_weights}
    assert made == needed


def run(file, *options, network="bisenet"):
    return main(["weights", "import", str(file), "--network", network, *options])


def test_a_checkpoint_becomes_a_model_with_the_same_outputs(tmp_path, capsys):
    tensors, module = public("torchseg")
    torch.save(
        {"model": tensors, "optimizer": {"state": {}}, "epoch": 80, "iteration": 1000}, tmp_path / "epoch-80.pth"
    )
    assert run(tmp_path / "epoch-80.pth") == 0
    assert "layout torchseg" in capsys.readouterr().out
    model = load_model((tmp_path / "epoch-80.foggy.safetensors").read_bytes())
    image = torch.randn(1, 3, 32, 64)
    with torch.inference_mode():
        assert torch.equal(
            model.network(image.contiguous(memory_format=torch.channels_last)),
            module.to(memory_format=torch.channels_last)(image.contiguous(memory_format=torch.channels_last)),
        )


def test_safetensors_are_read_and_written_alike(tmp_path):
    tensors, _ = public("drsleep", "refinenet")
    safetensors.torch.save_file(tensors, tmp_path / "a.safetensors")
    for out in ("b.safetensors", "c.safetensors"):
        assert run(tmp_path / "a.safetensors", "--out", str(tmp_path / out), network="refinenet") == 0
    assert (tmp_path / "b.safetensors").read_bytes() == (tmp_path / "c.safetensors").read_bytes()


def write_matlab(path, arrays, head):
    """An HDF5 file as MATLAB 7.3 writes a struct array of parameters and a layer with filters and biases."""
    with h5py.File(path, "w") as file:
        held = file.create_group("#refs#")
        names, values = [], []
        for number, (name, array) in enumerate(arrays.items()):
            text = held.create_dataset(f"n{number}", data=np.array([[ord(letter)] for letter in name], np.uint16))
            text.attrs["MATLAB_class"] = np.bytes_("char")
            value = held.create_dataset(f"v{number}", data=array.T)
            value.attrs["MATLAB_class"] = np.bytes_("single")
            names.append(text.ref)
            values.append(value.ref)
        params = held.create_group("net/params")
        for field, references in (("name", names), ("value", values)):
            params.create_dataset(field, data=np.array(references, dtype=h5py.ref_dtype)[:, None])
        layer = held.create_group("layer")
        for field, array in head.items():
            layer.create_dataset(field, data=array.T)


def matlab_arrays():
    tensors, module = public("matconvnet", "refinenet")
    arrays, head = {}, {}
    for name, tensor in tensors.items():
        unit, value = name.rsplit(".", 1)
        array = tensor.permute(2, 3, 1, 0).numpy() if tensor.ndim == 4 else tensor[None].numpy()
        if unit == "clf_conv":
            head["filters" if value == "weight" else "biases"] = array
        elif unit.startswith("bn"):
            if value == "running_mean":
                variance = tensors[f"{unit}.running_var"]
                arrays[f"{unit}_moments"] = torch.stack([tensor, (variance + 1e-5).sqrt()], 1).numpy()
            elif value in ("weight", "bias"):
                arrays[f"{unit}_{'mult' if value == 'weight' else 'bias'}"] = array.T
        else:
            arrays[f"{unit}_{'filter' if value == 'weight' else 'bias'}"] = array
    return arrays, head, module


def test_a_matlab_file_becomes_a_model(tmp_path, capsys):
    arrays, head, module = matlab_arrays()
    write_matlab(tmp_path / "refinenet.mat", arrays, head)
    assert run(tmp_path / "refinenet.mat", network="refinenet") == 0
    assert "layout matconvnet" in capsys.readouterr().out
    model = load_model((tmp_path / "refinenet.foggy.safetensors").read_bytes())
    assert model.config.stride_in == "1x1"
    assert model.preprocessing.mean == (128.0, 128.0, 128.0)
    wanted = module.state_dict()
    for name, tensor in model.network.state_dict().items():
        assert torch.allclose(tensor, wanted[name], atol=1e-6), name


def test_a_matlab_file_without_parameters_is_refused(tmp_path, capsys):
    write_matlab(tmp_path / "empty.mat", {}, {})
    assert run(tmp_path / "empty.mat", network="refinenet") == 1
    assert "no parameters" in capsys.readouterr().err
    (tmp_path / "old.mat").write_bytes(b"MATLAB 5.0 MAT-file")
    assert run(tmp_path / "old.mat", network="refinenet") == 1
    assert "7.3" in capsys.readouterr().err


def refused(capsys, tmp_path, file, *parts, options=(), network="bisenet"):
    before = sorted(path.name for path in tmp_path.iterdir())
    assert run(file, *options, network=network) == 1
    message = capsys.readouterr().err
    assert "Traceback" not in message
    for part in parts:
        assert part in message
    assert sorted(path.name for path in tmp_path.iterdir()) == before


def test_a_missing_and_an_extra_tensor_are_named_and_refused_unless_told_otherwise(tmp_path, capsys):
    tensors, _ = public("torchseg")
    tensors["stranger"] = tensors.pop("heads.2.conv_1x1.bias")
    torch.save(tensors, tmp_path / "a.pth")
    refused(capsys, tmp_path, tmp_path / "a.pth", "1 tensors missing: head.classifier.bias", "left over: stranger")
    assert run(tmp_path / "a.pth", "--lenient") == 0
    assert "stranger" in capsys.readouterr().out
    with pytest.raises(ValueError, match="part of a network"):
        load_model((tmp_path / "a.foggy.safetensors").read_bytes())


def test_a_checkpoint_of_the_other_network_is_refused(tmp_path, capsys):
    torch.save(public("torchseg")[0], tmp_path / "a.pth")
    refused(capsys, tmp_path, tmp_path / "a.pth", "weights of bisenet", network="refinenet")


def test_a_pickle_that_would_run_code_is_refused_and_not_run(tmp_path, capsys):
    class Trap:
        def __reduce__(self):
            return (tmp_path.joinpath("sprung").touch, ())

    torch.save({"model": public("torchseg")[0], "extra": Trap()}, tmp_path / "a.pth")
    (tmp_path / "b.pth").write_bytes(pickle.dumps(Trap()))
    for name in ("a.pth", "b.pth"):
        refused(capsys, tmp_path, tmp_path / name, "a.pth" if name == "a.pth" else "b.pth")
    assert not tmp_path.joinpath("sprung").exists()


def test_a_truncated_file_is_refused(tmp_path, capsys):
    torch.save(public("torchseg")[0], tmp_path / "a.pth")
    data = (tmp_path / "a.pth").read_bytes()
    (tmp_path / "a.pth").write_bytes(data[: len(data) // 2])
    refused(capsys, tmp_path, tmp_path / "a.pth", "a.pth")
    (tmp_path / "b.safetensors").write_bytes(b"12345678{}")
    refused(capsys, tmp_path, tmp_path / "b.safetensors", "b.safetensors")


def test_a_file_without_tensors_is_refused(tmp_path, capsys):
    torch.save({"epoch": 3}, tmp_path / "a.pth")
    refused(capsys, tmp_path, tmp_path / "a.pth", "no named tensors")
    refused(capsys, tmp_path, tmp_path / "none.pth", "none.pth")


def test_a_wrong_call_ends_with_status_2(tmp_path):
    torch.save({}, tmp_path / "a.pth")
    assert run(tmp_path / "a.pth", "--out", str(tmp_path / "a.pth")) == 2
    assert main(["weights"]) == 2
    assert run(tmp_path / "a.pth", network="unet") == 2
