"""RefineNet with ResNet-101, the paper's accurate network; its layers are in `refinenet_layers`."""

import re
from typing import TYPE_CHECKING

from foggy_synscapes.networks.config import NetworkConfig, NetworkEntry, Preprocessing
from foggy_synscapes.networks.layouts import Layout, caffe_backbone, caffe_name, torchvision_backbone

if TYPE_CHECKING:
    from foggy_synscapes.networks.network import Network


def _build(config: NetworkConfig) -> "Network":
    from foggy_synscapes.networks.refinenet_layers import RefineNet

    return RefineNet(config)


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
    inner = re.fullmatch(r"(adapt|refine|pool\.links)\.(\d)\.(.+)", rest)
    if inner is None:
        raise ValueError(f"{name}: no name of this network")
    part, number, rest = inner.groups()
    count = int(number) + 1
    if part == "pool.links":
        return f"mflow_conv_g{level}_pool.0.{count}_outvar_dimred.weight"
    group = f"adapt_stage{level}_b" if part == "adapt" else f"mflow_conv_g{level}_b"
    middle = "_conv." if rest.startswith("first.") else "_conv_relu_varout_dimred."
    return f"{group}.0.{count}{middle}{rest.partition('.')[2]}"


def _matconvnet(name: str, config: NetworkConfig) -> str:
    """Names as `matconvnet.tensors` gives them: Caffe's in the backbone, in the decoder those DrSleep's come from."""
    if name.startswith("backbone."):
        return re.sub("^scale", "bn", caffe_name(name, config))
    name = re.sub(r"(adapt_stage|mflow_conv_g)(\d)_b\.0\.", r"\1\2_b", _drsleep(name, config))
    return re.sub(r"_pool\.0\.", "_pool", name)


# The names of the public models, DrSleep/refinenet-pytorch and guosheng/refinenet (MatConvNet); only names are taken.
DRSLEEP = Layout(
    "drsleep",
    "refinenet",
    marks=(r"adapt_stage1_b\.0\.1_conv\.weight",),
    backbone=torchvision_backbone,
    translate=_drsleep,
)
MATCONVNET = Layout(
    "matconvnet",
    "refinenet",
    marks=(r"adapt_stage1_b1_conv\.weight",),
    backbone=caffe_backbone,
    translate=_matconvnet,
    preprocessing=Preprocessing(scale=1.0, mean=(128.0, 128.0, 128.0), std=(1.0, 1.0, 1.0)),
    settings={"stride_in": "1x1"},
)

NETWORK = NetworkEntry(
    "refinenet",
    title="RefineNet",
    order=0,
    backbone="resnet101",
    width=64,
    decoder=256,
    build=_build,
    sizes={"classes": ("head.weight", 0), "decoder": ("head.weight", 1)},
    layouts=(DRSLEEP, MATCONVNET),
)
