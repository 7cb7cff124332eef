"""Model files: weights, architecture and preprocessing in one safetensors file.

The file's metadata has one key, `foggy`, with sorted JSON: several keys would be written in no fixed order.
"""

import json
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
import safetensors.torch
import torch
from safetensors import SafetensorError
from torch import Tensor

from foggy_synscapes.networks.config import NetworkConfig, Preprocessing
from foggy_synscapes.networks.network import Network, build

KEY = "foggy"
FORMAT = 1


@dataclass
class Model:
    """A network ready to predict, with the preprocessing that belongs to its weights."""

    network: Network
    preprocessing: Preprocessing

    @property
    def config(self) -> NetworkConfig:
        return self.network.config

    def logits(self, rgb: np.ndarray) -> Tensor:
        """rgb uint8 (H, W, 3), any size -> logits float32 (classes, H, W)."""
        if rgb.dtype != np.uint8 or rgb.ndim != 3 or rgb.shape[2] != 3:
            raise ValueError(f"rgb: {rgb.dtype} {rgb.shape}, expected uint8 (H, W, 3)")
        device = next(self.network.parameters()).device
        images = torch.from_numpy(np.ascontiguousarray(rgb)).to(device).permute(2, 0, 1)[None]
        self.network.eval()
        with torch.inference_mode():
            # Of one image, this layout is a view, and convolutions on processors are faster in it.
            inputs = self.preprocessing.apply(images).contiguous(memory_format=torch.channels_last)
            return self.network(inputs)[0].float()

    def predict(self, rgb: np.ndarray) -> np.ndarray:
        """rgb uint8 (H, W, 3), any size -> trainIds uint8 (H, W)."""
        return self.logits(rgb).argmax(dim=0).to(torch.uint8).cpu().numpy()


def dump(module: Network, preprocessing: Preprocessing) -> bytes:
    """The model file of a network: equal weights give equal bytes."""
    return dump_tensors(module.state_dict(), module.config, preprocessing)


def dump_tensors(
    tensors: dict[str, Tensor], config: NetworkConfig, preprocessing: Preprocessing, part: str = "network"
) -> bytes:
    """A file of weights; part : "network", "backbone" or "some", of which the rest starts at random (`load_start`)."""
    about = {"format": FORMAT, "part": part, "network": asdict(config), "preprocessing": asdict(preprocessing)}
    return pack(tensors, KEY, about)


def pack(tensors: dict[str, Tensor], key: str, about: dict) -> bytes:
    """A safetensors file, with `about` as JSON under a key of its metadata: the inverse of `read_tensors`."""
    plain = {name: tensor.detach().cpu().contiguous() for name, tensor in tensors.items()}
    return safetensors.torch.save(plain, {key: json.dumps(about, sort_keys=True)})


def load_model(data: bytes) -> Model:
    """Read a model file made by `dump`.

    Raises ValueError if it is no safetensors file, was cut off, was not made by this project, is not of a whole
    network, or its tensors do not fit its config.
    """
    part, config, preprocessing, tensors = _read(data)
    if part != "network":
        raise ValueError(
            "weights of a part of a network, from which training can start; no whole model to predict with"
        )
    with torch.device("meta"):
        network = build(config)
    check_fit(network, tensors)
    network.load_state_dict(tensors, strict=True, assign=True)
    network.to(memory_format=torch.channels_last)  # type: ignore[call-overload]  # missing in PyTorch's types
    return Model(network.eval(), preprocessing)


def load_start(data: bytes, wanted: NetworkConfig, whole: bool = False) -> Model:
    """A network to train from a file of weights, or of a part of them; the rest is random, as `build` leaves it.

    wanted : the network to train. The formulation (`variant`, `stride_in`) is the file's: its weights were made for it.
    whole : refuse a part of a network; auxiliary heads, which predictions do not use, may be missing still

    Raises ValueError as `load_model` does, and if the file's sizes are not those of the wanted network.
    """
    part, config, preprocessing, tensors = _read(data)
    if whole and part != "network":
        raise ValueError("weights of a part of a network, from which training can start, but no whole model")
    sizes = ("backbone", "width") if part == "backbone" else ("name", "backbone", "width", "decoder", "classes")
    different = [f"{key} {getattr(config, key)}, wanted {getattr(wanted, key)}" for key in sizes
                 if getattr(config, key) != getattr(wanted, key)]  # fmt: skip
    if different:
        raise ValueError(f"weights of another network: {'; '.join(different)}")
    network = build(replace(wanted, variant=config.variant, stride_in=config.stride_in))
    complete = part == "network" and config.auxiliary == wanted.auxiliary
    assign_values(network, tensors if complete else {**network.state_dict(), **tensors})
    return Model(network, preprocessing)


def _read(data: bytes) -> tuple[str, NetworkConfig, Preprocessing, dict[str, Tensor]]:
    about, tensors = read_tensors(data, KEY)
    if about.get("format") != FORMAT:
        raise ValueError(f"model file of format {about.get('format')!r}, expected {FORMAT}: made by another version?")
    plain: dict[str, Any] = {
        name: tuple(value) if isinstance(value, list) else value for name, value in about["preprocessing"].items()
    }
    try:
        return about["part"], NetworkConfig(**about["network"]), Preprocessing(**plain), tensors
    except TypeError as error:
        raise ValueError(f"model file with other fields than this version knows: {error}") from error


def _kinds(tensors: dict[str, Tensor]) -> dict[str, tuple]:
    return {name: (tensor.dtype, *tensor.shape) for name, tensor in tensors.items()}


NORM_EPSILON = 1e-5
"""What batch norm adds to variances; those of other frameworks, less what these had added, may be a little below 0."""


def check_fit(network: Network, tensors: dict[str, Tensor]) -> None:
    """Raise ValueError, saying what does not fit, unless names, shapes and types are exactly the network's."""
    about = f"weights do not fit {network.config.name} ({network.config.backbone})"
    wanted, given = _kinds(network.state_dict()), _kinds(tensors)
    missing, extra = sorted(wanted.keys() - given.keys()), sorted(given.keys() - wanted.keys())
    if missing or extra:
        raise ValueError(
            f"{about}: {len(missing)} tensors missing {missing[:3]}, {len(extra)} left over {extra[:3]}. "
            "Is this another network's file?"
        )
    for name in wanted:
        if given[name] != wanted[name]:
            raise ValueError(
                f"{about}: {name} is {given[name]}, expected {wanted[name]}. "
                "Has it another width or another number of classes?"
            )
        if name.endswith("running_var") and not bool((tensors[name] + NORM_EPSILON > 0).all()):
            raise ValueError(
                f"{about}: {name} holds {float(tensors[name].min()):g}, expected variances from 0 on. Is it damaged?"
            )


def assign_values(network: Network, tensors: dict[str, Tensor]) -> None:
    """Copy weights into a network that exists, keeping its device and layout in memory (see `check_fit`)."""
    check_fit(network, tensors)
    network.load_state_dict(tensors, strict=True)


def read_tensors(data: bytes, key: str) -> tuple[dict, dict[str, Tensor]]:
    """Metadata (JSON under `key`) and tensors of a safetensors file; ValueError where it is none, or lacks the key."""
    try:
        tensors = safetensors.torch.load(data)
        header = json.loads(data[8 : 8 + int.from_bytes(data[:8], "little")])
    except (SafetensorError, ValueError) as error:
        raise ValueError(f"no whole safetensors file ({error}). Was it cut off, or is it of another kind?") from error
    try:
        return json.loads(header["__metadata__"][key]), tensors
    except (KeyError, TypeError):
        raise ValueError(
            f"safetensors file without the metadata `{key}`: not made here. `foggy weights import` reads other sources"
        ) from None
