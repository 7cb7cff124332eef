"""How public weights name their tensors: what the networks declare, and the layouts of backbones alone.

Sources: torchvision's ResNet, whose names are ours, and Kaiming He's deep-residual-networks (Caffe). Only names are
taken from them. Nothing here imports PyTorch.
"""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from foggy_synscapes.networks.config import BACKBONES, NETWORKS, NetworkConfig, Preprocessing


@dataclass(frozen=True)
class Layout:
    """One way in which public weights name their tensors.

    network : the network that it is of, or None for a backbone alone
    marks : names (regular expressions) that all occur in files of this layout; a backbone's do in whole networks too
    backbone : a file's names -> key of `BACKBONES`; raises ValueError
    translate : our name and the config -> the name there
    settings : fields of the config that all files of this layout share
    ignored : names (regular expression) that belong to the layout and have no use here, such as ImageNet's classifier
    """

    name: str
    network: str | None
    marks: tuple[str, ...]
    backbone: Callable[[Iterable[str]], str]
    translate: Callable[[str, NetworkConfig], str]
    preprocessing: Preprocessing = field(default_factory=Preprocessing)
    settings: Mapping[str, Any] = field(default_factory=dict)
    ignored: str = r"$^"

    def fits(self, names: Iterable[str]) -> bool:
        """Whether a file with these names is of this layout."""
        return all(any(re.fullmatch(mark, name) for name in names) for mark in self.marks)


def by_rules(rules: Sequence[tuple[str, str]]) -> Callable[[str, NetworkConfig], str]:
    """A `translate` by the first of several (regular expression of our name, replacement) that matches."""

    def translate(name: str, _config: NetworkConfig) -> str:
        for pattern, replacement in rules:
            found = re.fullmatch(pattern, name)
            if found:
                return found.expand(replacement)
        raise ValueError(f"{name}: has no counterpart in this layout")

    return translate


def caffe_name(name: str, config: NetworkConfig) -> str:
    """What a parameter of our backbone is called in Caffe's ResNet, such as res4b12_branch2a.weight.

    A norm's own parameters are a layer "scale" there, its statistics one named "bn".
    """
    unit, _, value = name.rpartition(".")
    norm = "scale" if value in ("weight", "bias") else "bn"
    found = re.fullmatch(r"backbone\.layer(\d)\.(\d+)\.(?:(conv|bn)(\d)|downsample\.(\d))", unit)
    if not found:
        return f"conv1.{value}" if unit == "backbone.conv1" else f"{norm}_conv1.{value}"
    stage, block, kind, number, shortcut = found.groups()
    # ResNet-101's long stages go on as b1, b2, ...; ResNet-50's as b, c, ...
    counted = config.backbone == "resnet101" and stage in "23" and block != "0"
    letter = f"b{block}" if counted else chr(ord("a") + int(block))
    branch = "1" if shortcut else "2" + "abc"[int(number) - 1]
    prefix = "res" if kind == "conv" or shortcut == "0" else norm
    return f"{prefix}{int(stage) + 1}{letter}_branch{branch}.{value}"


def caffe_backbone(names: Iterable[str]) -> str:
    """The backbone whose blocks occur among Caffe's names; ValueError if there is none."""
    blocks = {found[0] for name in names if (found := re.match(r"res\d[a-z]\d*_", name))}
    backbone = {16: "resnet50", 33: "resnet101"}.get(len(blocks))
    if backbone is None:
        raise ValueError(f"backbone of {len(blocks)} blocks: expected the 16 of ResNet-50 or the 33 of ResNet-101")
    return backbone


def torchvision_backbone(names: Iterable[str], prefix: str = "") -> str:
    """The backbone whose blocks occur under a prefix of torchvision's names; ValueError if there is none."""
    pattern = re.compile(re.escape(prefix) + r"layer(\d)\.(\d+)\.(conv3)?")
    found = [match.groups() for name in names if (match := pattern.match(name))]
    depths = tuple(len({block for at, block, _ in found if at == stage}) for stage in "1234")
    shape = depths, any(third for _, _, third in found)
    for backbone, known in BACKBONES.items():
        if known == shape:
            return backbone
    raise ValueError(f"backbone of {depths} blocks a stage: expected one of {', '.join(BACKBONES)}")


TORCHVISION = Layout(
    "torchvision",
    None,
    marks=(r"layer1\.0\.conv1\.weight", r"bn1\.running_mean"),
    backbone=torchvision_backbone,
    translate=lambda name, _config: name.removeprefix("backbone."),
    ignored=r"fc\.(weight|bias)",
)
CAFFE = Layout(
    "caffe",
    None,
    marks=(r"res2a_branch2a\.weight",),
    backbone=caffe_backbone,
    translate=caffe_name,
    preprocessing=Preprocessing("BGR", 1.0, (103.939, 116.779, 123.68), (1.0, 1.0, 1.0)),
    settings={"stride_in": "1x1"},
    ignored=r"fc1000\.(weight|bias)",
)


def layouts() -> dict[str, Layout]:
    """All layouts by name; those of backbones come last, as their names occur in files of whole networks too."""
    own = [layout for name in NETWORKS for layout in NETWORKS[name].layouts]
    return {layout.name: layout for layout in (*own, TORCHVISION, CAFFE)}


def detect(names: Sequence[str]) -> Layout:
    """The layout of a file by its tensors' names; ValueError if there is none, listing what is known."""
    known = layouts()
    found = next((layout for layout in known.values() if layout.fits(names)), None)
    # Light-weight forms of networks have torchvision's names in the backbone, and these in a decoder that is not ours.
    if found is None or (found.network is None and any(name.startswith("p_ims1d2") for name in names)):
        raise ValueError(
            f"unknown layout: {len(names)} tensors such as {sorted(names)[:4]}; known are {', '.join(known)}. "
            "Light-weight forms of networks are not among them."
        )
    return found
