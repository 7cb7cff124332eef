"""Public weights in every layout: each name has its place, and the outputs are those of the public network.

The public networks are in tests/helpers/public_layouts.py.
"""

import re

import numpy as np
import pytest
import torch
from public_layouts import (
    CLASSES,
    DECODER,
    IMAGE,
    WIDTH,
    Reader,
    coincheung,
    drsleep,
    imported,
    to_caffe,
    torchseg,
    torchvision,
)

from foggy_synscapes.networks.config import NetworkConfig
from foggy_synscapes.networks.importing import convert, from_matconvnet
from foggy_synscapes.networks.weights import dump_tensors, load_model, load_start


@pytest.mark.parametrize("backbone", ["resnet18", "resnet50"])
def test_drsleep_refinenet_gives_the_same_logits(backbone):
    tensors = drsleep(backbone)
    found, network = imported(tensors, "refinenet")
    assert found.layout == "drsleep"
    assert (found.config.backbone, found.config.width, found.config.decoder) == (backbone, WIDTH, DECODER)
    assert found.config.classes == CLASSES
    assert len(found.tensors) == len(tensors)
    with torch.inference_mode():
        expected = Reader(tensors).drsleep(IMAGE)
        assert float((network.outputs(IMAGE)[0] - expected).abs().max()) <= 1e-5 * float(expected.abs().max())


def test_torchseg_bisenet_gives_the_same_logits():
    tensors = torchseg()
    found, network = imported(tensors, "bisenet")
    assert found.layout == "torchseg"
    assert len(found.tensors) == len(tensors)
    with torch.inference_mode():
        expected = Reader(tensors).torchseg(IMAGE)
        assert float((network(IMAGE) - expected).abs().max()) <= 1e-5 * float(expected.abs().max())


@pytest.mark.parametrize("auxiliary", [True, False])
def test_coincheung_bisenet_gives_the_same_logits(auxiliary):
    tensors = coincheung(auxiliary)
    found, network = imported(tensors, "bisenet")
    assert (found.layout, found.config.variant, found.config.auxiliary) == ("coincheung", "coincheung", auxiliary)
    assert found.preprocessing.mean == (0.3257, 0.3690, 0.3223)
    with torch.inference_mode():
        expected = Reader(tensors).coincheung(IMAGE)
        assert float((network(IMAGE) - expected).abs().max()) <= 1e-5 * float(expected.abs().max())


@pytest.mark.parametrize("backbone", ["resnet18", "resnet50"])
def test_torchvision_backbone_gives_the_same_maps(backbone):
    tensors = torchvision(backbone)
    found = convert(tensors, "bisenet")
    assert (found.part, found.missing, found.left_over) == ("backbone", [], [])
    wanted = NetworkConfig("bisenet", backbone, WIDTH, DECODER)
    data = dump_tensors(found.tensors, found.config, found.preprocessing, found.part)
    network = load_start(data, wanted).network.eval()
    with torch.inference_mode():
        for ours, expected in zip(network.backbone(IMAGE), Reader(tensors).resnet(IMAGE, ""), strict=True):
            assert torch.allclose(ours, expected, rtol=1e-4, atol=1e-5)


def test_backbone_converted_from_caffe_has_its_stride_and_preprocessing():
    tensors = torchvision("resnet50")
    found = convert(tensors, "refinenet", "caffe")
    assert (found.preprocessing.channels, found.preprocessing.scale) == ("BGR", 1.0)
    data = dump_tensors(found.tensors, found.config, found.preprocessing, found.part)
    network = load_start(data, NetworkConfig("refinenet", "resnet50", WIDTH, DECODER, auxiliary=False)).network.eval()
    with torch.inference_mode():
        expected = Reader(tensors).resnet(IMAGE, "", stride_in=1)
        assert torch.allclose(network.backbone(IMAGE)[3], expected[3], rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("backbone", ["resnet50", "resnet101"])
def test_caffe_names_have_one_place_each(backbone):
    tensors = torchvision(backbone)
    found = convert(to_caffe(tensors, backbone), "refinenet")
    assert (found.layout, found.config.backbone, found.missing, found.left_over) == ("caffe", backbone, [], [])
    for name, tensor in found.tensors.items():
        assert torch.equal(tensor, tensors[name.removeprefix("backbone.")].to(tensor.dtype))


def to_matconvnet(tensors, backbone):
    """DrSleep's tensors as MatConvNet keeps RefineNet: Caffe's names for the backbone, axes and moments of its own."""
    arrays = {}
    resnet = {name: tensor for name, tensor in tensors.items() if re.match(r"conv1|bn1|layer", name)}
    rest = {name: tensor for name, tensor in tensors.items() if name not in resnet}
    plain = {name: t for name, t in to_caffe(resnet, backbone).items() if not name.endswith("num_batches_tracked")}
    for name, tensor in plain.items():
        unit, value = name.rsplit(".", 1)
        if value == "weight" and tensor.ndim == 4:
            arrays[f"{unit}_filter"] = tensor.permute(2, 3, 1, 0).numpy()
        elif value == "weight":
            arrays[unit.replace("scale", "bn", 1) + "_mult"] = tensor[:, None].numpy()
        elif value == "bias":
            arrays[unit.replace("scale", "bn", 1) + "_bias"] = tensor[:, None].numpy()
        elif value == "running_mean":
            deviation = (plain[f"{unit}.running_var"] + 1e-5).sqrt()
            arrays[f"{unit}_moments"] = torch.stack([tensor, deviation], 1).numpy()
    for name, tensor in rest.items():
        unit, value = name.rsplit(".", 1)
        unit = re.sub(r"_b\.0\.(\d)", r"_b\1", re.sub(r"_pool\.0\.(\d)", r"_pool\1", unit))
        if unit == "clf_conv":
            kind = "filters" if value == "weight" else "biases"
        else:
            kind = f"{unit}_filter" if value == "weight" else f"{unit}_bias"
        arrays[kind] = tensor.permute(2, 3, 1, 0).numpy() if tensor.ndim == 4 else tensor[None].numpy()
    return arrays


def test_matconvnet_refinenet_gives_the_same_logits():
    tensors = drsleep("resnet50")
    found, network = imported(from_matconvnet(to_matconvnet(tensors, "resnet50")), "refinenet")
    assert (found.layout, found.config.stride_in) == ("matconvnet", "1x1")
    with torch.inference_mode():
        expected = Reader(tensors).drsleep(IMAGE, stride_in=1)
        assert float((network.outputs(IMAGE)[0] - expected).abs().max()) <= 1e-4 * float(expected.abs().max())


def test_matconvnet_pooling_of_the_improved_kind_is_not_taken_for_the_other():
    arrays = to_matconvnet(drsleep("resnet50"), "resnet50")
    moved = {re.sub(r"_pool1_outvar_dimred", "_poolprev_relu_varout_pb1", name): v for name, v in arrays.items()}
    found = convert(from_matconvnet(moved), "refinenet")
    assert len(found.missing) == len(found.left_over) == 4


@pytest.mark.parametrize(
    "bad", [{"conv1_momentum": np.zeros((1, 1))}, {"bn_moments": np.zeros(3)}, {"x_filter": np.zeros(3)}]
)
def test_matconvnet_array_of_another_kind_is_named(bad):
    with pytest.raises(ValueError, match=next(iter(bad))):
        from_matconvnet(bad)


def test_wrapped_names_are_unwrapped():
    wrapped = {f"module.{name}": tensor for name, tensor in torchseg().items()}
    assert convert(wrapped, "bisenet").missing == []


def test_old_file_without_counters_is_whole():
    tensors = {name: t for name, t in torchseg().items() if not name.endswith("num_batches_tracked")}
    assert convert(tensors, "bisenet").missing == []


def test_half_precision_is_widened():
    tensors = {name: t.half() if t.is_floating_point() else t for name, t in torchseg().items()}
    assert convert(tensors, "bisenet").tensors["head.classifier.weight"].dtype == torch.float32


def test_missing_and_left_over_tensors_are_named():
    tensors = torchseg()
    tensors["stranger"] = tensors.pop("heads.2.conv_1x1.bias")
    found = convert(tensors, "bisenet")
    assert (found.missing, found.left_over) == (["head.classifier.bias"], ["stranger"])


def test_tensor_of_another_shape_is_missing_and_left_over():
    tensors = torchseg()
    tensors["refines.0.conv.weight"] = torch.zeros(1, 2, 3, 3)
    found = convert(tensors, "bisenet")
    assert (found.missing, found.left_over) == (["refine32.conv.weight"], ["refines.0.conv.weight"])


@pytest.mark.parametrize(
    ("tensors", "network", "layout", "message"),
    [
        ({"a": torch.zeros(1)}, "bisenet", "auto", "unknown layout"),
        ({"p_ims1d2_outl1_dimred.weight": torch.zeros(1)}, "refinenet", "auto", "Light-weight"),
        (torchseg(), "refinenet", "auto", "weights of bisenet"),
        (torchseg(), "bisenet", "coincheung", "names are those of torchseg"),
        (torchseg(), "bisenet", "other", "expected auto or one of"),
        ({k: v for k, v in torchseg().items() if "layer4" not in k}, "bisenet", "auto", "blocks a stage"),
        ({k: v for k, v in torchseg().items() if "heads.2" not in k}, "bisenet", "auto", "size of the network"),
    ],
)
def test_what_cannot_be_is_refused(tensors, network, layout, message):
    with pytest.raises(ValueError, match=message):
        convert(tensors, network, layout)


def test_part_of_a_network_is_no_model_and_must_fit():
    found = convert(torchvision("resnet18"), "bisenet")
    data = dump_tensors(found.tensors, found.config, found.preprocessing, found.part)
    with pytest.raises(ValueError, match="part of a network"):
        load_model(data)
    with pytest.raises(ValueError, match="width 8, wanted 16"):
        load_start(data, NetworkConfig("bisenet", "resnet18", 16, DECODER))
