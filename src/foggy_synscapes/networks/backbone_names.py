"""Public names of the backbone's parameters: torchvision's, which are ours, and those of Caffe's ResNet.

Sources: torchvision's ResNet, and the models of Kaiming He's deep-residual-networks. Only names are taken from them.
"""

import re
from collections.abc import Iterable

from foggy_synscapes.networks.config import BACKBONES, NetworkConfig

_STATISTICS = {"weight": "scale", "bias": "scale", "running_mean": "bn", "running_var": "bn"}


def _caffe_unit(name: str, config: NetworkConfig) -> tuple[str, str]:
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


def caffe_name(name: str, config: NetworkConfig) -> str:
    """What a parameter of our backbone is called in Caffe's ResNet."""
    unit, _, value = name.rpartition(".")
    place, kind = _caffe_unit(unit, config)
    stem = place == "conv1"
    if kind == "res":
        return f"conv1.{value}" if stem else f"res{place}.{value}"
    prefix = _STATISTICS.get(value, "bn")
    return f"{prefix}_{place}.{value}" if stem else f"{prefix}{place}.{value}"


def caffe_backbone(names: Iterable[str]) -> str:
    """The backbone whose blocks occur among Caffe's names; ValueError if there is none."""
    blocks = {found[0] for name in names if (found := re.match(r"res\d[a-z]\d*_", name))}
    backbone = {16: "resnet50", 33: "resnet101"}.get(len(blocks))
    if backbone is None:
        raise ValueError(f"backbone of {len(blocks)} blocks: expected the 16 of ResNet-50 or the 33 of ResNet-101")
    return backbone


def torchvision_backbone(names: Iterable[str], prefix: str = "") -> str:
    """The backbone whose blocks occur under a prefix of torchvision's names; ValueError if there is none."""
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
