"""BiSeNet v1 with ResNet-18, the paper's fast network; its layers are in `bisenet_layers`."""

from functools import partial
from typing import TYPE_CHECKING

from foggy_synscapes.networks.config import NetworkConfig, NetworkEntry, Preprocessing
from foggy_synscapes.networks.layouts import Layout, by_rules, torchvision_backbone

if TYPE_CHECKING:
    from foggy_synscapes.networks.network import Network

# The parameter names of the public formulations, yu-changqian/TorchSeg and CoinCheung/BiSeNet; only names are taken.
TORCHSEG_RULES = (
    (r"backbone\.(.+)", r"context_path.\1"),
    (r"spatial\.0\.(.+)", r"spatial_path.conv_7x7.\1"),
    (r"spatial\.([12])\.(.+)", r"spatial_path.conv_3x3_\1.\2"),
    (r"spatial\.3\.(.+)", r"spatial_path.conv_1x1.\1"),
    (r"whole\.(.+)", r"global_context.1.\1"),
    (r"attention32\.features\.(.+)", r"arms.0.conv_3x3.\1"),
    (r"attention32\.attention\.(.+)", r"arms.0.channel_attention.1.\1"),
    (r"attention16\.features\.(.+)", r"arms.1.conv_3x3.\1"),
    (r"attention16\.attention\.(.+)", r"arms.1.channel_attention.1.\1"),
    (r"refine32\.(.+)", r"refines.0.\1"),
    (r"refine16\.(.+)", r"refines.1.\1"),
    (r"fusion\.features\.(.+)", r"ffm.conv_1x1.\1"),
    (r"fusion\.attention\.0\.weight", r"ffm.channel_attention.1.conv.weight"),
    (r"fusion\.attention\.2\.weight", r"ffm.channel_attention.2.conv.weight"),
    (r"head32\.features\.(.+)", r"heads.0.conv_3x3.\1"),
    (r"head32\.classifier\.(.+)", r"heads.0.conv_1x1.\1"),
    (r"head16\.features\.(.+)", r"heads.1.conv_3x3.\1"),
    (r"head16\.classifier\.(.+)", r"heads.1.conv_1x1.\1"),
    (r"head\.features\.(.+)", r"heads.2.conv_3x3.\1"),
    (r"head\.classifier\.(.+)", r"heads.2.conv_1x1.\1"),
)

COINCHEUNG_RULES = (
    (r"backbone\.(.+)", r"cp.resnet.\1"),
    (r"spatial\.0\.(.+)", r"sp.conv1.\1"),
    (r"spatial\.1\.(.+)", r"sp.conv2.\1"),
    (r"spatial\.2\.(.+)", r"sp.conv3.\1"),
    (r"spatial\.3\.(.+)", r"sp.conv_out.\1"),
    (r"whole\.(.+)", r"cp.conv_avg.\1"),
    (r"attention(32|16)\.features\.(.+)", r"cp.arm\1.conv.\2"),
    (r"attention(32|16)\.attention\.conv\.(.+)", r"cp.arm\1.conv_atten.\2"),
    (r"attention(32|16)\.attention\.bn\.(.+)", r"cp.arm\1.bn_atten.\2"),
    (r"refine(32|16)\.(.+)", r"cp.conv_head\1.\2"),
    (r"fusion\.features\.(.+)", r"ffm.convblk.\1"),
    (r"fusion\.attention\.(conv|bn)\.(.+)", r"ffm.\1.\2"),
    (r"head(32|16|)\.features\.(.+)", r"conv_out\1.conv.\2"),
    (r"head(32|16|)\.classifier\.(.+)", r"conv_out\1.conv_out.\2"),
)


def _check(config: NetworkConfig) -> None:
    if config.variant not in VARIANTS:
        raise ValueError(f"variant: {config.variant!r}, expected {' or '.join(VARIANTS)}")
    if config.decoder % 4:
        raise ValueError(f"decoder: {config.decoder}, expected a multiple of 4")


def _build(config: NetworkConfig) -> "Network":
    from foggy_synscapes.networks.bisenet_layers import BiSeNet

    return BiSeNet(config)


TORCHSEG = Layout(
    "torchseg",
    "bisenet",
    marks=(r"context_path\..+", r"spatial_path\..+"),
    backbone=partial(torchvision_backbone, prefix="context_path."),
    translate=by_rules(TORCHSEG_RULES),
    settings={"variant": "torchseg"},
    ignored=r"context_path\.fc\..+",
)
COINCHEUNG = Layout(
    "coincheung",
    "bisenet",
    marks=(r"cp\.resnet\..+", r"sp\.conv1\..+"),
    backbone=partial(torchvision_backbone, prefix="cp.resnet."),
    translate=by_rules(COINCHEUNG_RULES),
    preprocessing=Preprocessing(mean=(0.3257, 0.3690, 0.3223), std=(0.2112, 0.2148, 0.2115)),
    settings={"variant": "coincheung"},
)
VARIANTS = (TORCHSEG.name, COINCHEUNG.name)

NETWORK = NetworkEntry(
    "bisenet",
    title="BiSeNet",
    order=1,
    backbone="resnet18",
    width=64,
    decoder=128,
    build=_build,
    head="head32.classifier.weight",
    sizes={"classes": ("head.classifier.weight", 0), "decoder": ("whole.conv.weight", 0)},
    layouts=(TORCHSEG, COINCHEUNG),
    check=_check,
)
