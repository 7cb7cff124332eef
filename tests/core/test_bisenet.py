"""BiSeNet is the published architecture in both public formulations, and takes images of any size."""

from dataclasses import replace

import pytest
import torch

from foggy_synscapes.networks import NETWORKS, NetworkConfig
from foggy_synscapes.networks.catalogue import multiply_adds, parameters
from foggy_synscapes.networks.network import build

TINY = NetworkConfig("bisenet", "resnet18", width=8, decoder=4)


@pytest.mark.parametrize(
    ("variant", "auxiliary", "count"),
    [
        ("torchseg", True, 13_494_777),
        ("torchseg", False, 12_894_163),
        ("coincheung", True, 13_425_721),
        ("coincheung", False, 13_275_539),
    ],
)
def test_count_of_parameters_is_the_published_one(variant, auxiliary, count):
    assert parameters(replace(NETWORKS["bisenet"].published, variant=variant, auxiliary=auxiliary)) == count


def test_multiply_adds_are_the_published_ones():
    assert round(multiply_adds(NETWORKS["bisenet"].published) / 1e9, 1) == 25.9


@pytest.mark.parametrize("variant", ["torchseg", "coincheung"])
@pytest.mark.parametrize("size", [(1, 1), (33, 47), (64, 32)])
def test_any_size_comes_out_at_its_own_size(variant, size):
    network = build(replace(TINY, variant=variant)).eval()
    with torch.inference_mode():
        assert network(torch.zeros(1, 3, *size)).shape == (1, 19, *size)


def test_auxiliary_outputs_exist_in_training_only():
    network = build(TINY)
    images = torch.zeros(2, 3, 64, 96)
    assert [tuple(logits.shape[2:]) for logits in network.train().outputs(images)] == [(8, 12), (8, 12), (4, 6)]
    assert len(network.eval().outputs(images)) == 1
    assert len(build(replace(TINY, auxiliary=False)).train().outputs(images)) == 1


def test_decoder_must_be_a_multiple_of_4():
    with pytest.raises(ValueError, match="multiple of 4"):
        replace(TINY, decoder=6)
