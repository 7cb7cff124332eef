"""RefineNet is the published architecture and takes images of any size."""

from dataclasses import replace

import pytest
import torch

from foggy_synscapes.networks import NETWORKS, NetworkConfig
from foggy_synscapes.networks.catalogue import multiply_adds, parameters
from foggy_synscapes.networks.network import build

TINY = NetworkConfig("refinenet", "resnet18", width=8, decoder=4, auxiliary=False)


def test_count_of_parameters_is_the_published_one():
    assert parameters(NETWORKS["refinenet"].published) == 118_047_827
    assert parameters(replace(NETWORKS["refinenet"].published, classes=21)) == 118_052_437


def test_multiply_adds_are_the_published_ones():
    assert round(multiply_adds(NETWORKS["refinenet"].published) / 1e9, 1) == 525.6


@pytest.mark.parametrize("size", [(1, 1), (33, 47), (64, 32), (100, 31)])
def test_any_size_comes_out_at_its_own_size(size):
    network = build(TINY).eval()
    with torch.inference_mode():
        assert network(torch.zeros(1, 3, *size)).shape == (1, 19, *size)


def test_training_output_has_stride_4():
    outputs = build(TINY).train().outputs(torch.zeros(2, 3, 64, 96))
    assert [tuple(logits.shape) for logits in outputs] == [(2, 19, 16, 24)]


def test_padding_leaves_a_size_that_fits_alone():
    torch.manual_seed(0)
    network = build(TINY).eval()
    image = torch.randn(1, 3, 32, 64)
    with torch.inference_mode():
        below = network.outputs(image)[0]
        expected = torch.nn.functional.interpolate(below, size=(32, 64), mode="bilinear", align_corners=True)
        assert torch.equal(network(image), expected)


@pytest.mark.parametrize(
    ("field", "value"), [("name", "unet"), ("backbone", "vgg16"), ("width", 7), ("decoder", 2), ("classes", 1)]
)
def test_impossible_config_names_the_field(field, value):
    with pytest.raises(ValueError, match=field):
        replace(TINY, **{field: value})


def test_image_without_pixels_is_refused():
    with pytest.raises(ValueError, match="images"):
        build(TINY).eval()(torch.zeros(1, 3, 0, 8))
