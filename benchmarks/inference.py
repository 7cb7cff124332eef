"""How fast a published network predicts, and in how much memory: python benchmarks/inference.py [--network bisenet]

The network of the paper with random weights, on random images of 1024 x 512 pixels: from 8-bit RGB to trainIds, by each
way of `foggy tradeoff`. CPU milliseconds of one thread, medians and minima; the ways are measured in turn, so that all
meet the same machine. Target: ONNX int8 at least 3 times as fast as PyTorch float32 (what it costs in mean IoU needs a
trained network: `foggy tradeoff --part networks`).

--memory instead predicts one image of 2048 x 1024 as `foggy evaluate` does, by RefineNet on ResNet-101, and prints the
peak of the resident memory. Target: 8 GB.
"""

import argparse
import resource
import statistics
import time

import numpy as np
import torch

from foggy_synscapes.networks import NETWORKS
from foggy_synscapes.networks.network import build
from foggy_synscapes.networks.weights import Model, Preprocessing
from foggy_synscapes.tradeoff.networks import EAGER, INT8, THREADS, backends_at

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--network", choices=NETWORKS.names(), default="bisenet")
parser.add_argument("--size", type=int, nargs=2, default=(512, 1024), metavar=("ROWS", "COLUMNS"), help="pixels")
parser.add_argument("--rounds", type=int, default=10)
parser.add_argument("--memory", action="store_true")


def image(height: int, width: int, seed: int) -> np.ndarray:
    """Blocks of random colours: uint8 (height, width, 3)."""
    random = np.random.default_rng(seed)
    blocks = random.integers(0, 256, (-(-height // 16), -(-width // 16), 3), np.uint8)
    return blocks.repeat(16, 0).repeat(16, 1)[:height, :width].copy()


def published(network: str) -> Model:
    torch.manual_seed(0)
    return Model(build(NETWORKS[network].published).eval(), Preprocessing())


def speed(network: str, height: int, width: int, rounds: int) -> None:
    ways = backends_at(published(network), 1.0, [image(height, width, seed) for seed in range(2)])
    rgb, times = image(height, width, 9), {way: [] for way in ways}
    for number in range(rounds + 1):
        for way, run in ways.items():
            started = time.thread_time()
            run.classes(rgb)
            if number:  # the first finds its memory
                times[way].append(1000 * (time.thread_time() - started))
    plain = statistics.median(times[EAGER])
    print(f"{network} at {width} x {height}, {THREADS} thread, CPU ms per image:")
    for way, taken in times.items():
        middle = statistics.median(taken)
        print(f"  {way:<17} median {middle:7.1f}  least {min(taken):7.1f}  {plain / middle:.2f} times as fast")
    if INT8 in times:
        ratio = plain / statistics.median(times[INT8])
        print(f"int8 is {ratio:.2f} times as fast as {EAGER} ({'good' if ratio >= 3 else 'below 3'})")


def memory() -> None:
    model = published("refinenet")
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    model.predict(image(1024, 2048, 0))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(
        f"refinenet on resnet101 at 2048 x 1024: peak {peak / 1e6:.2f} GB, {before / 1e6:.2f} GB of it before "
        f"predicting ({'good' if peak < 8e6 else 'above 8'})"
    )


torch.set_num_threads(THREADS)
arguments = parser.parse_args()
if arguments.memory:
    memory()
else:
    speed(arguments.network, *arguments.size, arguments.rounds)
