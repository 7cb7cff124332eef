"""The parameter names of public weights: for each layout, what a parameter of ours is called there.

Sources: the public definitions of the networks in DrSleep/refinenet-pytorch, yu-changqian/TorchSeg, CoinCheung/BiSeNet,
torchvision, Caffe's ResNet and guosheng/refinenet (MatConvNet). Only names are taken from them.
"""

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from foggy_synscapes.networks.config import BACKBONES, NetworkConfig
from foggy_synscapes.networks.weights import Preprocessing

IMAGENET = Preprocessing()
CAFFE = Preprocessing("BGR", 1.0, (103.939, 116.779, 123.68), (1.0, 1.0, 1.0))
COINCHEUNG = Preprocessing("RGB", 1 / 255, (0.3257, 0.3690, 0.3223), (0.2112, 0.2148, 0.2115))
MATCONVNET = Preprocessing("RGB", 1.0, (128.0, 128.0, 128.0), (1.0, 1.0, 1.0))

Rules = tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Layout:
    """One way in which public weights name their tensors.

    network : the network that it is of, or None for a backbone alone
    marks : names (regular expressions) that all occur in files of this layout, and together in none above it
    backbone : what stands before torchvision's names of the backbone
    translate : our name and the config -> the name there
    ignored : names (regular expression) that belong to the layout and have no use here, such as ImageNet's classifier
    """

    name: str
    network: str | None
    marks: tuple[str, ...]
    backbone: str
    translate: Callable[[str, NetworkConfig], str]
    preprocessing: Preprocessing
    ignored: str = r"$^"

    def fits(self, names: Iterable[str]) -> bool:
        """Whether a file with these names is of this layout."""
        names = list(names)
        return all(any(re.fullmatch(mark, name) for name in names) for mark in self.marks)


def _by_rules(rules: Rules) -> Callable[[str, NetworkConfig], str]:
    def translate(name: str, _config: NetworkConfig) -> str:
        for pattern, replacement in rules:
            found = re.fullmatch(pattern, name)
            if found:
                return found.expand(replacement)
        raise ValueError(f"{name}: has no counterpart in this layout")

    return translate


def _drsleep(name: str, config: NetworkConfig) -> str:
    """DrSleep counts levels from the deepest (1) to the finest (4), we from the finest (0)."""
    found = re.fullmatch(r"levels\.(\d)\.(.+)", name)
    if not found:
        return name.removeprefix("backbone.").replace("head.", "clf_conv.")
    level, rest = 4 - int(found[1]), found[2]
    fixed = {
        "reduce.weight": f"p_ims1d2_outl{level}_dimred.weight",
        "fuse_fine.weight": f"adapt_stage{level}_b2_joint_varout_dimred.weight",
        "fuse_coarse.weight": f"mflow_conv_g{level - 1}_b3_joint_varout_dimred.weight",
    }
    if rest in fixed:
        return fixed[rest]
    part, number, rest = re.fullmatch(r"(adapt|refine|pool\.links)\.(\d)\.(.+)", rest).groups()
    count = int(number) + 1
    if part == "pool.links":
        return f"mflow_conv_g{level}_pool.0.{count}_outvar_dimred.weight"
    group = f"adapt_stage{level}_b" if part == "adapt" else f"mflow_conv_g{level}_b"
    middle = "_conv." if rest.startswith("first.") else "_conv_relu_varout_dimred."
    return f"{group}.0.{count}{middle}{rest.partition('.')[2]}"


TORCHSEG_RULES: Rules = (
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

COINCHEUNG_RULES: Rules = (
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

_CAFFE_STATISTICS = {"weight": "scale", "bias": "scale", "running_mean": "bn", "running_var": "bn"}


def caffe_unit(name: str, config: NetworkConfig) -> tuple[str, str]:
    """Where one of our backbone's layers is in Caffe's ResNet, such as "4b12_branch2a", and its kind, "res" or "bn".

    "res" are convolutions, "bn" norms; the stem's place is "conv1".
    """
    found = re.fullmatch(r"backbone\.layer(\d)\.(\d+)\.(?:(conv|bn)(\d)|downsample\.(\d))", name)
    if not found:
        return "conv1", "res" if name == "backbone.conv1" else "bn"
    stage, block = int(found[1]), int(found[2])
    if found[5] is not None:
        branch, kind = "1", "res" if found[5] == "0" else "bn"
    else:
        branch, kind = "2" + "abc"[int(found[4]) - 1], "res" if found[3] == "conv" else "bn"
    # ResNet-101's long stages go on as b1, b2, ...; ResNet-50's as b, c, ...
    counted = config.backbone == "resnet101" and stage in (2, 3) and block > 0
    letter = f"b{block}" if counted else chr(ord("a") + block)
    return f"{stage + 1}{letter}_branch{branch}", kind


def _caffe(name: str, config: NetworkConfig) -> str:
    unit, _, value = name.rpartition(".")
    place, kind = caffe_unit(unit, config)
    stem = place == "conv1"
    if kind == "res":
        return f"conv1.{value}" if stem else f"res{place}.{value}"
    prefix = _CAFFE_STATISTICS.get(value, "bn")
    return f"{prefix}_{place}.{value}" if stem else f"{prefix}{place}.{value}"


def _matconvnet(name: str, config: NetworkConfig) -> str:
    """Names as `matconvnet.tensors` gives them: Caffe's in the backbone, in the decoder those DrSleep's come from."""
    if name.startswith("backbone."):
        return re.sub("^scale", "bn", _caffe(name, config))
    name = re.sub(r"(adapt_stage|mflow_conv_g)(\d)_b\.0\.", r"\1\2_b", _drsleep(name, config))
    return re.sub(r"_pool\.0\.", "_pool", name)


LAYOUTS = {
    layout.name: layout
    for layout in (
        Layout("matconvnet", "refinenet", (r"adapt_stage1_b1_conv\.weight",), "", _matconvnet, MATCONVNET),
        Layout("drsleep", "refinenet", (r"adapt_stage1_b\.0\.1_conv\.weight",), "", _drsleep, IMAGENET),
        Layout(
            "torchseg",
            "bisenet",
            (r"context_path\..+", r"spatial_path\..+"),
            "context_path.",
            _by_rules(TORCHSEG_RULES),
            IMAGENET,
            ignored=r"context_path\.fc\..+",
        ),
        Layout(
            "coincheung",
            "bisenet",
            (r"cp\.resnet\..+", r"sp\.conv1\..+"),
            "cp.resnet.",
            _by_rules(COINCHEUNG_RULES),
            COINCHEUNG,
        ),
        Layout(
            "torchvision",
            None,
            (r"layer1\.0\.conv1\.weight", r"bn1\.running_mean"),
            "",
            lambda name, _config: name.removeprefix("backbone."),
            IMAGENET,
            ignored=r"fc\.(weight|bias)",
        ),
        Layout("caffe", None, (r"res2a_branch2a\.weight",), "", _caffe, CAFFE, ignored=r"fc1000\.(weight|bias)"),
    )
}


def detect(names: Iterable[str]) -> Layout:
    """The layout of a file by its tensors' names; ValueError if there is none, listing what is known."""
    names = list(names)
    known = next((layout for layout in LAYOUTS.values() if layout.fits(names)), None)
    if known is None or (known.network is None and any(name.startswith("p_ims1d2") for name in names)):
        raise ValueError(
            f"unknown layout: {len(names)} tensors such as {sorted(names)[:4]}; known are {', '.join(LAYOUTS)}. "
            "Light-weight RefineNet and other networks are not among them."
        )
    return known


def backbone_of(names: Iterable[str], prefix: str) -> str:
    """The backbone whose blocks occur under a prefix of torchvision's names, such as "resnet50"."""
    blocks: dict[int, set[int]] = {}
    bottleneck = False
    for name in names:
        found = re.match(re.escape(prefix) + r"layer(\d)\.(\d+)\.(conv3)?", name)
        if found:
            blocks.setdefault(int(found[1]), set()).add(int(found[2]))
            bottleneck |= found[3] is not None
    depths = tuple(len(blocks.get(stage, ())) for stage in range(1, 5))
    for backbone, known in BACKBONES.items():
        if known == (depths, bottleneck):
            return backbone
    raise ValueError(f"backbone of {depths} blocks a stage: expected one of {', '.join(BACKBONES)}")
