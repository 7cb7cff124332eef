"""`foggy weights import`: public weights as start weights or models of this project."""

import argparse
import io
import pickle
import warnings
from pathlib import Path

import safetensors.torch
import torch
from safetensors import SafetensorError
from torch import Tensor

from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.io.atomic import write_bytes
from foggy_synscapes.io.files import LARGEST_WEIGHTS, named, read_bytes
from foggy_synscapes.io.matlab import read_parameters
from foggy_synscapes.networks import NETWORKS
from foggy_synscapes.networks.importing import Imported, convert, from_matconvnet
from foggy_synscapes.networks.layouts import layouts
from foggy_synscapes.networks.weights import dump_tensors

HELP = "Import public weights: whole networks, or backbones to start from."
CONTAINERS = ("state_dict", "model", "model_state", "net", "weights")  # keys under which checkpoints keep the tensors


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="import")
    verb = verbs.add_parser("import", help="turn a public file into a safetensors file of this project")
    verb.add_argument("file", type=Path, metavar="FILE", help="weights: .pth, .pt, .safetensors or .mat (MatConvNet)")
    verb.add_argument("--network", required=True, choices=NETWORKS.names(), help="network that they are for")
    verb.add_argument("--out", type=Path, metavar="FILE", help="file to write (default: FILE with .foggy.safetensors)")
    verb.add_argument(
        "--layout",
        default="auto",
        choices=["auto", *layouts()],
        help="how the file names its tensors (default: by its names); caffe where torchvision's names hold a backbone "
        "converted from Caffe",
    )
    verb.add_argument(
        "--lenient",
        action="store_true",
        help="accept missing tensors (they start at random) and drop those left over, instead of refusing the file",
    )


def run(args: argparse.Namespace) -> None:
    """Run the command."""
    out = args.out or args.file.with_name(args.file.name.partition(".")[0] + ".foggy.safetensors")
    if out == args.file:
        raise UsageError(f"--out {out}: is the file that is read")
    weights(args.file, args.network, out, args.layout, args.lenient)


def weights(file: Path, network: str, out: Path, layout: str = "auto", lenient: bool = False) -> None:
    """Import a public file; what is read, and what does not fit, is printed.

    Raises FoggyError if the file cannot be read without running code in it, if its layout is unknown or of another
    network, or if a tensor is missing or left over and not `lenient`.
    """
    try:
        found = convert(_read(file), network, layout)
    except ValueError as error:
        raise FoggyError(f"{file}: {error}") from error
    if not lenient and (found.missing or found.left_over):
        raise FoggyError(f"{file}: {_misfits(found)}. Is the file whole? With --lenient the rest is used as it is.")
    part = "some" if found.missing else found.part
    write_bytes(out, dump_tensors(found.tensors, found.config, found.preprocessing, part))
    print(_summary(found, file, out))


def _misfits(found: Imported) -> str:
    both = ((found.missing, "missing"), (found.left_over, "left over"))
    return "; ".join(
        f"{len(names)} tensors {word}: {', '.join(names[:8])}{', ...' if len(names) > 8 else ''}"
        for names, word in both
        if names
    )


def _summary(found: Imported, file: Path, out: Path) -> str:
    config, prepared = found.config, found.preprocessing
    of = "" if found.part == "network" else "backbone of "
    lines = [
        f"{file}: layout {found.layout}, {of}{config.name} on {config.backbone}, width {config.width}"
        + (f", decoder {config.decoder}, {config.classes} classes" if found.part == "network" else ""),
        f"{out}: {len(found.tensors)} tensors; input is {prepared.channels} * {prepared.scale:.6g}, "
        f"minus {prepared.mean}, divided by {prepared.std}",
    ]
    misfits = _misfits(found)
    return "\n".join([*lines, f"not used or missing, as --lenient allows: {misfits}"] if misfits else lines)


def _read(path: Path) -> dict[str, Tensor]:
    """Tensors of a file by name. Code in pickles is refused, not run."""
    if path.suffix == ".mat":
        return from_matconvnet(read_parameters(path))
    data = read_bytes(path, "file of weights", limit=LARGEST_WEIGHTS)
    try:
        with named(path, "file of weights", "Is it whole?"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            if path.suffix == ".safetensors":
                return safetensors.torch.load(data)
            content = torch.load(io.BytesIO(data), map_location="cpu", weights_only=True)
    except pickle.UnpicklingError as error:
        raise FoggyError(
            f"{path}: holds more than tensors, and reading it would run code in it; it was not run. "
            f"Save its state_dict alone, or as safetensors ({str(error).splitlines()[0]})"
        ) from error
    except (SafetensorError, RuntimeError, EOFError) as error:
        raise FoggyError(f"{path}: not a whole file of weights: {error}") from error
    return _tensors(content, path)


def _tensors(content: object, path: Path) -> dict[str, Tensor]:
    """The tensors of a checkpoint, which may hold them under a key beside its optimiser and step."""
    while isinstance(content, dict):
        tensors = {name: value for name, value in content.items() if isinstance(value, torch.Tensor)}
        if tensors and all(isinstance(name, str) for name in tensors):
            return tensors
        inner = next((content[key] for key in CONTAINERS if isinstance(content.get(key), dict)), None)
        if inner is None:
            break
        content = inner
    raise FoggyError(f"{path}: holds no named tensors; expected a state_dict, alone or under {', '.join(CONTAINERS)}")
