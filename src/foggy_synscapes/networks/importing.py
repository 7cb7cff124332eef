"""Public weights, whatever their layout, as weights of our networks: every tensor finds its place, or is named."""

import re
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch
from torch import Tensor

from foggy_synscapes.networks.config import NETWORKS, NetworkConfig, Preprocessing
from foggy_synscapes.networks.layouts import Layout, detect, layouts
from foggy_synscapes.networks.network import build

WRAPPERS = ("module.", "model.", "network.")  # what wrapped modules put before every name
COUNTER = "num_batches_tracked"  # of batch norm; files older than PyTorch 0.4.1 lack it, and nothing here reads it
EPSILON = 1e-5  # what PyTorch's batch norm adds to the variance; MatConvNet's deviations include its own
HEAD = "clf_conv"


@dataclass(frozen=True)
class Imported:
    """Weights of one of our networks, or of its backbone alone.

    part : "network" or "backbone"; of a backbone alone, `decoder`, `classes` and `auxiliary` in the config say nothing
    tensors : by our names
    missing : names of that part (ours) without a tensor; left_over : names of the file without a place
    """

    layout: str
    part: str
    config: NetworkConfig
    preprocessing: Preprocessing
    tensors: dict[str, Tensor]
    missing: list[str]
    left_over: list[str]


def convert(tensors: dict[str, Tensor], network: str, layout: str = "auto") -> Imported:
    """Give every tensor of a public file its name in one of our networks.

    layout : one of `layouts()`, or "auto" to tell it by the names. "caffe" where the names are torchvision's means a
        backbone converted from Caffe: its preprocessing differs, and so does the place of the stride in a bottleneck

    Raises ValueError if the layout is unknown or is that of another network, or the sizes tell no architecture.
    """
    known = layouts()
    if layout != "auto" and layout not in known:
        raise ValueError(f"layout: {layout!r}, expected auto or one of {', '.join(known)}")
    tensors = unwrapped(tensors)
    found = detect(list(tensors))
    wanted = found if layout == "auto" else known[layout]
    if wanted is not found and (wanted.name, found.name) != ("caffe", "torchvision"):
        raise ValueError(f"layout: {wanted.name} was asked for, but the names are those of {found.name}")
    if found.network not in (None, network):
        raise ValueError(f"these are weights of {found.network} (layout {found.name}), not of {network}")
    config = replace(_config(tensors, network, found), **wanted.settings)
    return _placed(tensors, config, found, wanted.preprocessing)


def unwrapped(tensors: dict[str, Tensor]) -> dict[str, Tensor]:
    """The tensors without a wrapper's prefix, where all of their names have it."""
    for prefix in WRAPPERS:
        if tensors and all(name.startswith(prefix) for name in tensors):
            return unwrapped({name.removeprefix(prefix): tensor for name, tensor in tensors.items()})
    return tensors


def _config(tensors: dict[str, Tensor], network: str, layout: Layout) -> NetworkConfig:
    """The architecture that the names and sizes of a file tell."""
    entry = NETWORKS[network]

    def size(ours: str, axis: int) -> int:
        theirs = layout.translate(ours, entry.published)
        if theirs not in tensors:
            raise ValueError(f"{theirs}: missing, and with it the size of the network. Is the file whole?")
        return tensors[theirs].shape[axis]

    backbone, width = layout.backbone(tensors), size("backbone.conv1.weight", 0)
    config = replace(entry.published, backbone=backbone, width=width)
    if layout.network is None:
        return config
    auxiliary = entry.head is not None and layout.translate(entry.head, config) in tensors
    sizes: dict[str, Any] = {key: size(*place) for key, place in entry.sizes.items()}
    return replace(config, auxiliary=auxiliary, **sizes)


def _placed(
    tensors: dict[str, Tensor], config: NetworkConfig, layout: Layout, preprocessing: Preprocessing
) -> Imported:
    with torch.device("meta"):
        shapes = {name: tensor.shape for name, tensor in build(config).state_dict().items()}
    part = "network" if layout.network else "backbone"
    if part == "backbone":
        shapes = {name: shape for name, shape in shapes.items() if name.startswith("backbone.")}
    placed, missing, used = {}, [], set()
    for ours, shape in shapes.items():
        theirs = layout.translate(ours, config)
        if theirs in tensors and tensors[theirs].shape == shape:
            # Half precision files are widened; counters stay whole numbers.
            kind = torch.int64 if ours.endswith(COUNTER) else torch.float32
            placed[ours] = tensors[theirs].detach().to(kind).contiguous()
            used.add(theirs)
        elif ours.endswith(COUNTER):
            placed[ours] = torch.zeros(shape, dtype=torch.int64)
        else:
            missing.append(ours)
    left_over = [name for name in tensors if name not in used and not re.fullmatch(layout.ignored, name)]
    return Imported(layout.name, part, config, preprocessing, placed, sorted(missing), sorted(left_over))


def from_matconvnet(arrays: dict[str, np.ndarray]) -> dict[str, Tensor]:
    """MatConvNet's parameters in PyTorch's terms.

    arrays : as MATLAB shows them: "conv1_filter" (7, 7, 3, 64) is (rows, columns, inputs, outputs), "bn_conv1_moments"
        (64, 2) means and deviations, "bn_conv1_mult" (64, 1); the classifier's are "filters" and "biases"

    Returns float32 "conv1.weight" (64, 3, 7, 7), "bn_conv1.running_mean" (64), ...; raises ValueError for a name of
    another kind, or a shape that is not what its name promises.
    Source: the documentation of vl_nnconv and vl_nnbnorm.
    """
    found: dict[str, Tensor] = {}
    for name, array in arrays.items():
        values = torch.from_numpy(np.ascontiguousarray(array, dtype=np.float32))
        # The classifier is in a group of its own and has no name there.
        base, kind = {"filters": (HEAD, "filter"), "biases": (HEAD, "bias")}.get(name) or name.rpartition("_")[::2]
        if kind == "filter":
            if values.ndim != 4:
                raise ValueError(f"{name}: {tuple(values.shape)}, expected rows, columns, inputs and outputs")
            found[f"{base}.weight"] = values.permute(3, 2, 0, 1).contiguous()
        elif kind == "moments":
            if values.ndim != 2 or values.shape[1] != 2:
                raise ValueError(f"{name}: {tuple(values.shape)}, expected a mean and a deviation for each channel")
            found[f"{base}.running_mean"] = values[:, 0].contiguous()
            found[f"{base}.running_var"] = (values[:, 1].double() ** 2 - EPSILON).float()
        elif kind in ("mult", "bias"):
            found[f"{base}.{'weight' if kind == 'mult' else 'bias'}"] = values.flatten()
        else:
            raise ValueError(f"{name}: not a parameter of MatConvNet's layers (filter, bias, mult, moments)")
    return found
