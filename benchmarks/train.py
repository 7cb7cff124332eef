"""How fast a training step is: python benchmarks/train.py [--params params.yaml] [--rounds 6] [--steps 20]

For each network at the size and policy that the params give its baseline, on random images in memory:
  step     one step of the training loop, with order, augmentation, schedule, checks and curve
  plain    forward, backward and optimiser step alone, on one ready batch: the floor
  samples  drawing a batch: order, augmentation, collation; what a loader worker would take off the step
CPU milliseconds, medians; the loops are measured in turn, so that all meet the same machine. Target: step at most 5 %
above plain.

Then, with loader processes (0, 1 and 2): the share of a training's time that it waits for batches, whose images are
decoded from PNG each time, as where a list is too long for `train.cache`. Wall-clock time; target with one: below 5 %.
"""

import argparse
import os
import statistics
import time
from pathlib import Path

from foggy_synscapes.params import load

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--params", type=Path, default=Path("params.yaml"))
parser.add_argument("--rounds", type=int, default=6)
parser.add_argument("--steps", type=int, default=20, help="steps a round")
arguments = parser.parse_args()
params = load(arguments.params)
os.environ["OMP_NUM_THREADS"] = str(params.train.threads)

import numpy as np  # noqa: E402
import torch  # noqa: E402

from foggy_synscapes.io.images import encode_png, read_ids, read_rgb  # noqa: E402
from foggy_synscapes.networks import NetworkConfig  # noqa: E402
from foggy_synscapes.networks.network import build  # noqa: E402
from foggy_synscapes.networks.weights import Model, Preprocessing  # noqa: E402
from foggy_synscapes.training import loop, losses  # noqa: E402
from foggy_synscapes.training.learner import Arithmetic, Learner  # noqa: E402
from foggy_synscapes.training.loader import Steps  # noqa: E402


class Noise:
    """Random images of the stand-in's size, in memory."""

    count = 64

    def __init__(self) -> None:
        random, size = np.random.default_rng(0), tuple(params.scenes.stand_in.size)
        self.samples = [
            (random.integers(0, 256, (*size, 3), np.uint8), random.integers(0, 19, size, np.uint8)) for _ in range(64)
        ]

    def load(self, index: int) -> tuple[np.ndarray, np.ndarray]:
        return self.samples[index]

    def name(self, index: int) -> str:
        return str(index)


class Files(Noise):
    """Smooth images of the same size as the bytes of PNG files."""

    def __init__(self) -> None:
        random, (height, width) = np.random.default_rng(0), params.scenes.stand_in.size
        self.files = []
        for _ in range(self.count):
            coarse = random.integers(0, 19, (height // 16, width // 16), np.uint8)
            ids = np.kron(coarse, np.ones((16, 16), np.uint8))
            self.files.append((encode_png(np.stack([ids * 9, ids * 5, ids * 3], axis=-1)), encode_png(ids)))

    def load(self, index: int) -> tuple[np.ndarray, np.ndarray]:
        image, ids = self.files[index]
        return read_rgb(image, "image"), read_ids(ids, "ids")


def waiting(name: str) -> None:
    settings = params.train.network(name)
    policy = settings.baseline
    arithmetic = Arithmetic("cpu", params.train.precision, params.train.memory_format)
    network = build(NetworkConfig(name, settings.backbone, settings.width, settings.decoder))
    files, shares = Files(), []
    for workers in (0, 1, 2):
        count = arguments.steps * 2
        plan = loop.Plan(count, count, 10, count, 0, workers)
        model = Model(network, Preprocessing())
        outcome = loop.train(model, policy, plan, arithmetic, files, files, lambda _: None, {})
        shares.append(f"{workers}: {outcome.waited:.1%}")
    print(f"{name}: waits for batches, by loader processes, {', '.join(shares)} of the time")


def measure(name: str) -> None:
    settings = params.train.network(name)
    policy = settings.baseline
    arithmetic = Arithmetic("cpu", params.train.precision, params.train.memory_format)
    network = build(NetworkConfig(name, settings.backbone, settings.width, settings.decoder))
    noise, preprocessing = Noise(), Preprocessing()
    steps: dict[str, list[float]] = {"step": [], "plain": [], "samples": []}

    def clock(kind: str) -> float:
        now = time.process_time()
        steps[kind].append(now - clock.last)
        clock.last = time.process_time()
        return now

    def whole(count: int) -> None:
        plan = loop.Plan(count, count, 10, count, 0, 0)
        one = Noise()
        one.count = 1
        clock.last = time.process_time()
        loop.train(
            Model(network, preprocessing), policy, plan, arithmetic, noise, one, lambda _: None, {},
            report=lambda *_: clock("step"),
        )  # fmt: skip
        del steps["step"][-1]  # validates
        del steps["step"][-(count - 1)]  # begins

    def plain(count: int) -> None:
        learner = Learner(Model(network, preprocessing), policy, arithmetic)
        optimiser = learner.optimiser
        batch = Steps(noise, policy, 0, 0, 1)[0]
        with torch.no_grad():
            _, targets = learner.forward(batch.images, batch.labels)
        inputs = preprocessing.apply(batch.images).contiguous(memory_format=arithmetic.layout())
        for _ in range(count):
            clock.last = time.process_time()
            optimiser.zero_grad(set_to_none=True)
            with torch.autocast("cpu", torch.bfloat16, enabled=arithmetic.precision == "bfloat16"):
                outputs = network.outputs(inputs)
            loss = losses.total(outputs, targets, network.corners, policy)
            loss.backward()
            optimiser.step()
            clock("plain")

    def samples(count: int) -> None:
        drawn = Steps(noise, policy, 0, 0, count)
        clock.last = time.process_time()
        for _ in drawn:
            clock("samples")

    plain(3)
    for kind in steps:
        steps[kind].clear()
    for _ in range(arguments.rounds):
        whole(arguments.steps)
        plain(arguments.steps)
        samples(arguments.steps)
    middle = {kind: 1000 * statistics.median(values) for kind, values in steps.items()}
    over = middle["step"] / middle["plain"]
    figures = ", ".join(f"{kind} {value:.1f} ms" for kind, value in middle.items())
    print(f"{name}: {figures}; step is {over:.2f} of plain ({'good' if over <= 1.05 else 'above 1.05'})")


torch.set_num_threads(params.train.threads)
torch.use_deterministic_algorithms(True)
torch.utils.deterministic.fill_uninitialized_memory = False
for network_name in params.train.networks:
    measure(network_name)
    waiting(network_name)
