"""The registry of networks: an entry is all that is needed, and reading entries is cheap."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import torch

from foggy_synscapes.networks import NETWORKS, NetworkConfig, titles
from foggy_synscapes.networks.catalogue import catalogue
from foggy_synscapes.networks.importing import convert
from foggy_synscapes.networks.network import build
from foggy_synscapes.networks.weights import Preprocessing, dump, load_model
from foggy_synscapes.registry import UnknownEntry, use_plugins

PLUGIN = """
from functools import partial

from foggy_synscapes.networks.layouts import Layout, torchvision_backbone
from foggy_synscapes.networks.config import NetworkEntry


def _check(config):
    if config.decoder % 2:
        raise ValueError(f"decoder: {config.decoder}, expected an even number")


def _build(config):
    from foggy_plugins.plain_layers import Plain

    return Plain(config)


def _name(ours, config):
    return ours


AS_HERE = Layout("as_here", "plain", ("head.weight",), partial(torchvision_backbone, prefix="backbone."), _name)
NETWORK = NetworkEntry(
    "plain", title="PlainNet", order=2, backbone="resnet18", width=8, decoder=4, build=_build, check=_check,
    sizes={"classes": ("head.weight", 0)}, layouts=(AS_HERE,),
)
"""
LAYERS = """
from torch import nn

from foggy_synscapes.networks.network import Network
from foggy_synscapes.networks.resnet import ResNet


class Plain(Network):
    def __init__(self, config):
        super().__init__()
        self.config = config
        self.backbone = ResNet(config.backbone, config.width, config.stride_in)
        self.head = nn.Conv2d(self.backbone.channels[-1], config.classes, 1)

    def outputs(self, images):
        return [self.head(self.backbone(images)[-1])]
"""


@pytest.fixture
def plugin(tmp_path: Path) -> Iterator[None]:
    (tmp_path / "plain.py").write_text(PLUGIN)
    (tmp_path / "plain_layers.py").write_text(LAYERS)
    use_plugins(tmp_path)
    yield
    use_plugins(None)


@pytest.mark.usefixtures("plugin")
def test_a_network_of_the_users_own_is_built_saved_listed_and_imported() -> None:
    config = NETWORKS["plain"].published
    network = build(config)
    assert load_model(dump(network, Preprocessing())).config == config
    assert titles() == {"refinenet": "RefineNet", "bisenet": "BiSeNet", "plain": "PlainNet"}
    assert [entry["name"] for entry in catalogue()] == list(titles())
    found = convert(network.state_dict(), "plain")
    assert (found.layout, found.config, found.missing, found.left_over) == ("as_here", config, [], [])
    with pytest.raises(ValueError, match="even number"):
        NetworkConfig("plain", "resnet18", 8, 5)


def test_an_unknown_network_is_refused_with_those_that_are_known() -> None:
    with pytest.raises(UnknownEntry, match="'unet' is no network; there are bisenet, refinenet"):
        NETWORKS["unet"]
    with pytest.raises(ValueError, match="name: 'unet', expected one of bisenet, refinenet"):
        NetworkConfig("unet", "resnet18")


def test_reading_declarations_imports_no_pytorch() -> None:
    code = (
        "import sys; from foggy_synscapes.networks.layouts import layouts; "
        "from foggy_synscapes.networks import titles; titles(), layouts(); sys.exit('torch' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_every_declaration_builds_its_published_size() -> None:
    for name in NETWORKS:
        with torch.device("meta"):
            assert build(NETWORKS[name].published).config.name == name
