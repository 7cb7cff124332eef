"""Model files hold all that a prediction needs, and nothing is loaded that does not fit."""

from dataclasses import replace

import numpy as np
import pytest
import safetensors.torch
import torch

from foggy_synscapes.networks import NetworkConfig
from foggy_synscapes.networks.network import build
from foggy_synscapes.networks.weights import Preprocessing, dump, load_model

TINY = NetworkConfig("bisenet", "resnet18", width=8, decoder=4)


def tiny(config=TINY):
    torch.manual_seed(3)
    return build(config).eval()


@pytest.fixture(scope="module")
def data():
    return dump(tiny(), Preprocessing())


def test_round_trip_keeps_predictions_to_the_last_bit(data):
    rgb = np.random.default_rng(0).integers(0, 256, (45, 70, 3), dtype=np.uint8)
    model = load_model(data)
    network = tiny().to(memory_format=torch.channels_last)
    inputs = Preprocessing().apply(torch.from_numpy(rgb).permute(2, 0, 1)[None])
    with torch.inference_mode():
        expected = network(inputs.contiguous(memory_format=torch.channels_last))[0]
    assert torch.equal(model.logits(rgb), expected)
    predicted = model.predict(rgb)
    assert predicted.dtype == np.uint8
    assert np.array_equal(predicted, expected.argmax(0).numpy())


def test_same_weights_give_the_same_bytes(data):
    assert dump(load_model(data).network, Preprocessing()) == data


def test_preprocessing_travels_with_the_weights():
    caffe = Preprocessing("BGR", 1.0, (103.9, 116.8, 123.7), (1.0, 1.0, 1.0))
    assert load_model(dump(tiny(), caffe)).preprocessing == caffe


def test_preprocessing_orders_and_scales_channels():
    pixel = torch.tensor([10, 20, 30], dtype=torch.uint8).view(1, 3, 1, 1)
    values = Preprocessing("BGR", 0.5, (1.0, 2.0, 3.0), (1.0, 2.0, 4.0)).apply(pixel)
    assert values.flatten().tolist() == [14.0, 4.0, 0.5]


def test_cut_off_file_is_refused(data):
    with pytest.raises(ValueError, match="cut off"):
        load_model(data[:-10])


def test_pickle_is_refused_and_not_run(tmp_path):
    import pickle

    class Trap:
        def __reduce__(self):
            return (tmp_path.joinpath("sprung").touch, ())

    with pytest.raises(ValueError, match="safetensors"):
        load_model(pickle.dumps(Trap()))
    assert not tmp_path.joinpath("sprung").exists()


def test_file_of_other_origin_is_refused():
    with pytest.raises(ValueError, match="foggy weights import"):
        load_model(safetensors.torch.save({"conv1.weight": torch.zeros(1)}))


def altered(data, change):
    """The model file with its tensors changed and its metadata kept."""
    from safetensors import deserialize

    assert deserialize(data)
    import json

    header = json.loads(data[8 : 8 + int.from_bytes(data[:8], "little")])
    return safetensors.torch.save(change(safetensors.torch.load(data)), header["__metadata__"])


def test_left_over_and_missing_tensors_are_named(data):
    with pytest.raises(ValueError, match="stranger"):
        load_model(altered(data, lambda tensors: {**tensors, "stranger": torch.zeros(1)}))
    with pytest.raises(ValueError, match=r"1 tensors missing \['head.classifier.bias'\]"):
        load_model(altered(data, lambda t: {k: v for k, v in t.items() if k != "head.classifier.bias"}))


def test_other_class_count_is_named(data):
    with pytest.raises(ValueError, match="number of classes"):
        load_model(altered(data, lambda t: {**t, "head.classifier.bias": torch.zeros(21)}))


def test_weights_of_another_network_are_refused(data):
    from foggy_synscapes.networks.weights import assign_values

    refinenet = build(NetworkConfig("refinenet", "resnet18", width=8, decoder=4, auxiliary=False))
    with pytest.raises(ValueError, match="another network"):
        assign_values(refinenet, load_model(data).network.state_dict())
    with pytest.raises(ValueError, match="another width"):
        assign_values(tiny(replace(TINY, width=16)), load_model(data).network.state_dict())


@pytest.mark.parametrize("bad", [np.zeros((4, 4), np.uint8), np.zeros((4, 4, 4), np.uint8), np.zeros((4, 4, 3))])
def test_image_of_another_kind_is_refused(data, bad):
    with pytest.raises(ValueError, match="rgb"):
        load_model(data).predict(bad)
