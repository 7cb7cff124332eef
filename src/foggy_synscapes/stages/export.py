"""`foggy export`: a trained model as one file that runs without this project."""

import argparse
import sys
from pathlib import Path

import numpy as np
import torch

from foggy_synscapes.datasets.pairs import calibration_images
from foggy_synscapes.datasets.uris import Reader
from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.frames.compositing import composite
from foggy_synscapes.io.atomic import write_bytes
from foggy_synscapes.io.files import LARGEST_WEIGHTS, read_bytes
from foggy_synscapes.networks.device import take
from foggy_synscapes.networks.weights import Model, load_model
from foggy_synscapes.params import load
from foggy_synscapes.results import FOG, LIST, MODEL, roots, run_file
from foggy_synscapes.tradeoff.graph import Difference, Graph

HELP = (
    "Write a model as an ONNX graph: 8-bit RGB images (batch, height, width, 3) of any size in, trainIds or logits of "
    "that size out. Normalisation, padding and resizing are inside."
)
JOB = ("network", "row", "seed")
SIZES = ((128, 256), (75, 101))  # pixels of the images on which a graph is checked: whole strides, and not
TOLERANCE = 1e-3  # of the largest logit: what sums in another order may differ by in float32
PACKAGES = "onnx, onnxruntime and onnxscript. Install them by `pip install foggy-synscapes[export]`"


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("--format", default="onnx", choices=["onnx"], help="kind of file (default: onnx, opset 18)")
    parser.add_argument("--model", type=Path, metavar="FILE", help="model file, .safetensors")
    parser.add_argument("--network", help="instead of a file: network of a trained model, e.g. bisenet")
    parser.add_argument("--row", help="and its row of the tables, e.g. FS-498")
    parser.add_argument("--seed", help="and its seed, e.g. 0")
    parser.add_argument("--out", type=Path, required=True, metavar="FILE", help="file to write, .onnx")
    parser.add_argument(
        "--output",
        default="classes",
        choices=["classes", "logits"],
        help="classes: trainIds, uint8 (batch, height, width) (default); logits: float32 (batch, 19, height, width)",
    )
    parser.add_argument(
        "--scale",
        type=float,
        default=1.0,
        metavar="S",
        help="of the image's sides at which the network works, 0.01 to 1 (default: 1)",
    )
    parser.add_argument("--int8", action="store_true", help="compute in 8 bits, with ranges from calibration images")
    parser.add_argument(
        "--calibrate",
        type=Path,
        metavar="LIST",
        help="list of training images (CSV of `foggy subset`) for --int8 (default: the one that the row trained on)",
    )
    parser.add_argument(
        "--device",
        default="cpu",
        choices=["cpu", "cuda", "auto"],
        help="where PyTorch computes what the graph is compared with (default: cpu)",
    )
    parser.add_argument("--images", type=int, default=32, metavar="N", help="images of LIST to use (default: 32)")


def run(args: argparse.Namespace) -> None:
    """Run the command."""
    given = [f"--{name}" for name in JOB if getattr(args, name) is not None]
    if bool(args.model) == bool(given):
        raise UsageError("give --model, or --network, --row and --seed, and not both")
    if given and len(given) < len(JOB):
        raise UsageError(f"{', '.join(given)}: --network, --row and --seed belong together")
    if args.out.suffix != ".onnx":
        raise UsageError(f"--out {args.out}: expected a name that ends in .onnx")
    if not 0.01 <= args.scale <= 1:
        raise UsageError(f"--scale {args.scale}: expected 0.01 to 1")
    if args.images < 1:
        raise UsageError(f"--images {args.images}: expected 1 or more")
    if args.calibrate and not args.int8:
        raise UsageError("--calibrate: only --int8 looks at images")
    source = args.model or run_file(MODEL, network=args.network, row=args.row, seed=args.seed)
    images = []
    if args.int8:
        chosen = args.calibrate or (run_file(LIST, row=args.row) if args.row else None)
        if chosen is None:
            raise UsageError("--int8 with --model: name the images to calibrate on by --calibrate LIST")
        reader = Reader(roots(load(args.params)), FOG)
        images = calibration_images(chosen, reader, args.images, composite)
    export(source, args.out, args.output, args.scale, images, args.device)


def export(
    source: Path,
    out: Path,
    output: str = "classes",
    scale: float = 1.0,
    images: list[np.ndarray] | None = None,
    device: str = "cpu",
) -> Difference:
    """Write the graph of a model file, after comparing what ONNX Runtime makes of it with PyTorch; print how far.

    images : uint8 (H, W, 3), RGB: with them the graph is quantised to 8 bits, calibrated on them

    Raises FoggyError if the file is missing, damaged or no whole model; if a package is missing; if the logits of a
    float32 graph differ from PyTorch's by more than `TOLERANCE`.
    """
    try:
        device = take(device, torch.get_num_threads())
        model = load_model(read_bytes(source, "model", limit=LARGEST_WEIGHTS))
    except ValueError as error:
        raise FoggyError(f"{source}: {error}") from error
    try:
        from foggy_synscapes.tradeoff import onnx_export

        _say(f"tracing {model.config.name}")
        graph = onnx_export.to_onnx(model, scale)
        if images:
            _say(f"calibrating 8 bits on {len(images)} images")
            graph = onnx_export.to_int8(graph, images)
        random = np.random.default_rng(0)
        samples = images or [random.integers(0, 256, (*size, 3), np.uint8) for size in SIZES]
        _say(f"comparing with PyTorch on {len(samples)} images")
        difference = _compare(model, scale, graph, samples, device)
        data = onnx_export.with_output(graph, output)
    except ImportError as error:
        raise FoggyError(f"the ONNX format needs the packages {PACKAGES} ({error})") from error
    if not images and difference.largest > TOLERANCE * difference.magnitude:
        raise FoggyError(
            f"{source}: logits of the ONNX graph differ from PyTorch's by {difference.largest:.2g}, "
            f"{difference.magnitude:.2g} at most; nothing was written. Do its weights fit its architecture?"
        )
    write_bytes(out, data)
    kind = f"int8, calibrated on {len(images)} images" if images else "float32"
    print(
        f"{out}: {model.config.name}, {kind}, opset {onnx_export.OPSET}, input {onnx_export.INPUT}, output {output}\n"
        f"against PyTorch on {len(samples)} images: largest logit difference {difference.largest:.2g} (logits up to "
        f"{difference.magnitude:.2g}), {difference.changed_percent:.2g} % of the pixels of another class"
    )
    return difference


def _say(what: str) -> None:
    print(f"export: {what} ...", file=sys.stderr, flush=True)


def _compare(model: Model, scale: float, graph: bytes, images: list[np.ndarray], device: str) -> Difference:
    from foggy_synscapes.tradeoff.onnx_export import Session

    session, eager = Session(graph, torch.get_num_threads()), Graph(model, scale).eval().to(device)
    difference = Difference()
    for image in images:
        with torch.inference_mode():
            reference = eager(torch.from_numpy(image)[None].to(device))[0][0].cpu().numpy()
        difference.add(reference, session(image, "logits"))
    return difference
