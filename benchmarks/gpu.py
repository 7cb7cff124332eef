"""How the networks compute on a GPU, against the CPU and a plain loop: python benchmarks/gpu.py [--out docs/gpu.md]

For each network at its published size, with the crops of its fine-tuning in params/paper.yaml, on random images:
  in each precision, images a second of training steps and of evaluation, peak memory, the share of a step that waits
  for images, and how often a step waits for the GPU; beside it a plain PyTorch loop of the same network, loss and
  optimiser on one ready batch
  the largest difference of logits from float32 on the CPU: float32 without TensorFloat-32 has to stay within 1e-3
Then the smoke chain on the GPU with repeatable algorithms, twice: its tables have to be equal; and once more, killed in
its trainings: they have to end in the same models.
Where PyTorch finds no GPU it says so and ends well. `--device cpu` tries the program itself, at small sizes.
"""

import argparse
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
import warnings
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests/helpers"))

import numpy as np
import torch
from clones import ROOT, clone, table
from engines import hashes

from foggy_synscapes.networks import NETWORKS
from foggy_synscapes.networks.device import take
from foggy_synscapes.networks.network import build
from foggy_synscapes.networks.weights import Model, Preprocessing
from foggy_synscapes.params import load
from foggy_synscapes.provenance.runs import gpu
from foggy_synscapes.training import loop, losses
from foggy_synscapes.training.learner import Arithmetic, Learner
from foggy_synscapes.training.loader import Steps
from foggy_synscapes.training.policy import Policy

PRECISIONS = ("float32", "float32, TF32", "bfloat16", "float16")
STEPS, WARM = 20, 5
TOLERANCE = 1e-3
HEADS = (
    "network", "precision", "training, images / s", "plain loop, images / s", "waits for images", "waits a step",
    "peak memory, GB", "evaluation, images / s", "largest difference of logits",
)  # fmt: skip


class Noise:
    """Random images with labels in blocks, the same for every precision."""

    count = 32

    def __init__(self, size: tuple[int, int]) -> None:
        self.size = size

    def load(self, index: int) -> tuple[np.ndarray, np.ndarray]:
        random, (height, width) = np.random.default_rng(index), self.size
        labels = random.integers(0, 19, (height // 32, width // 32), np.uint8).repeat(32, 0).repeat(32, 1)
        return np.stack([labels * 9, labels * 5, labels * 3], axis=-1), labels

    def name(self, index: int) -> str:
        return str(index)


def fresh(name: str, published: bool) -> Model:
    """A network with random weights of a fixed seed; small where the program itself is tried."""
    torch.manual_seed(0)
    config = NETWORKS[name].published
    if not published:
        config = replace(config, backbone="resnet18", width=8, decoder=8)
    return Model(build(config), Preprocessing())


def synchronise(device: str) -> None:
    if device == "cuda":
        torch.cuda.synchronize()


def trained(model: Model, policy: Policy, arithmetic: Arithmetic, samples: Noise, workers: int) -> tuple[float, float]:
    """Images a second of the training loop, and the share of a step that waits for images."""
    ends: list[float] = []
    plan = loop.Plan(STEPS, STEPS, STEPS, STEPS, seed=0, workers=workers)
    outcome = loop.train(
        model, policy, plan, arithmetic, samples, None, lambda _: None, {},
        report=lambda *_: ends.append(time.perf_counter()),
    )  # fmt: skip
    return policy.batch * (STEPS - WARM) / (ends[-1] - ends[WARM - 1]), outcome.waited


def plain(model: Model, policy: Policy, arithmetic: Arithmetic, samples: Noise) -> tuple[float, float, int]:
    """Of one ready batch, images a second of a plain loop; of a step of ours, how often it waits for the GPU."""
    learner = Learner(model, policy, arithmetic)
    batch = Steps(samples, policy, 0, 0, 1)[0]
    waits = 0
    if arithmetic.device == "cuda":
        learner.step(batch.pin_memory())
        torch.cuda.set_sync_debug_mode("warn")
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            learner.step(batch.pin_memory())
        torch.cuda.set_sync_debug_mode("default")
        waits = sum("synchroniz" in str(warning.message) for warning in caught)
    with torch.no_grad():
        _, targets = learner.forward(batch.images, batch.labels)
    inputs = learner.preprocessing.apply(batch.images.to(arithmetic.device))
    inputs = inputs.contiguous(memory_format=arithmetic.layout())
    times = []
    for _ in range(STEPS):
        synchronise(arithmetic.device)
        begin = time.perf_counter()
        learner.optimiser.zero_grad(set_to_none=True)
        precision = getattr(torch, arithmetic.precision)
        with torch.autocast(arithmetic.device, precision, enabled=arithmetic.precision != "float32"):
            outputs = learner.network.outputs(inputs)
        loss = losses.total(outputs, targets, learner.network.corners, policy)
        learner.scaler.scale(loss).backward()
        learner.scaler.step(learner.optimiser)
        learner.scaler.update()
        synchronise(arithmetic.device)
        times.append(time.perf_counter() - begin)
    return policy.batch / statistics.median(times[WARM:]), 0.0, waits


def evaluated(model: Model, device: str, precision: str, image: np.ndarray) -> tuple[float, np.ndarray]:
    """Images a second of predictions at this size, and the logits."""
    model.network.to(device)
    times = []
    with torch.autocast(device, getattr(torch, precision), enabled=precision != "float32"):
        for _ in range(WARM + 5):
            begin = time.perf_counter()
            model.predict(image)
            times.append(time.perf_counter() - begin)
        logits = model.logits(image).float().cpu().numpy()
    return 1 / statistics.median(times[WARM:]), logits


def measure(name: str, device: str, workers: int) -> tuple[list[tuple[str, ...]], bool]:
    """Rows of the table of one network, and whether float32 is near enough to the CPU's."""
    published = device == "cuda"
    policy = load(ROOT / "params/paper.yaml").train.network(name).fine_tuning
    if not published:
        policy = Policy(**{**policy.model_dump(), "crop": (64, 64), "loss_stride": 8})
    size = (1024, 2048) if published else (64, 128)
    samples, image = Noise(size), Noise((512, 1024) if published else size).load(0)[0]
    take("cpu", torch.get_num_threads())
    reference = fresh(name, published).logits(image).numpy()
    rows, near = [], True
    for each in PRECISIONS:
        precision = each.partition(",")[0]
        take(device, torch.get_num_threads(), tf32="TF32" in each)
        arithmetic = Arithmetic(device, precision)
        if device == "cuda":
            torch.cuda.empty_cache()
            torch.cuda.reset_peak_memory_stats()
        speed, waited = trained(fresh(name, published), policy, arithmetic, samples, workers)
        peak = torch.cuda.max_memory_allocated() / 1e9 if device == "cuda" else 0.0
        floor, _, waits = plain(fresh(name, published), policy, arithmetic, samples)
        predicted, logits = evaluated(fresh(name, published), device, precision, image)
        far = float(np.abs(logits - reference).max())
        near &= each != "float32" or far <= TOLERANCE
        rows.append(
            (name, each, f"{speed:.1f}", f"{floor:.1f}", f"{waited:.1%}", str(waits), f"{peak:.1f}", f"{predicted:.1f}",
             f"{far:.2g}")
        )  # fmt: skip
    return rows, near


def chain(device: str) -> list[str]:
    """The smoke chain twice, and once with its trainings killed; one line for each comparison."""
    lines = []
    with tempfile.TemporaryDirectory() as scratch:
        found = []
        for number in range(3):
            folder = clone(Path(scratch) / str(number))
            overlay = f"base: smoke.yaml\ndevice: {device}\ngpu: {{deterministic: true}}\ntrain: {{snapshot: 1}}\n"
            (folder / "params/gpu.yaml").write_text(overlay)
            call = [sys.executable, "-m", "snakemake", "--cores", "1", "--configfile", "params/gpu.yaml"]
            if number == 2:
                killed(call, folder)
            subprocess.run(call, cwd=folder, check=True, capture_output=True)
            found.append(hashes(folder))
        for what, other in (("run twice", found[1]), ("killed and gone on with", found[2])):
            different = sorted(path for path, value in found[0].items() if other.get(path) != value)
            named = f": {', '.join(different[:5])}" if different else ""
            lines.append(f"Smoke chain, {what}: {len(found[0])} files, {len(different)} different{named}")
    return lines


def killed(call: list[str], folder: Path) -> None:
    """Start the chain, and kill it with all its jobs once a training has left a snapshot."""
    quiet = subprocess.DEVNULL
    with subprocess.Popen(call, cwd=folder, stdout=quiet, stderr=quiet, start_new_session=True) as run:
        while run.poll() is None and not list(folder.glob("results/train/**/snapshot.safetensors")):
            time.sleep(0.02)
        if run.poll() is None:
            os.killpg(run.pid, signal.SIGKILL)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, help="Markdown page to write (default: print it)")
    parser.add_argument("--device", default="cuda", choices=["cuda", "cpu"])
    parser.add_argument("--workers", type=int, default=4, help="loader processes")
    parser.add_argument("--no-chain", action="store_true", help="leave the smoke chain out")
    arguments = parser.parse_args()
    if arguments.device == "cuda" and not torch.cuda.is_available():
        print(f"gpu-check: skipped, PyTorch {torch.__version__} finds no GPU")
        return 0
    rows, good = [], True
    for name in NETWORKS:
        found, near = measure(name, arguments.device, arguments.workers)
        rows += found
        good &= near
    about = gpu() if arguments.device == "cuda" else {"model": "a CPU, to try the program: its figures mean nothing"}
    where = ", ".join(f"{key} {value}" for key, value in about.items())
    lines = ["# On a GPU", f"Made by `make gpu-check`: {where}."]
    lines += ["", table(HEADS, rows), "", f"float32 within {TOLERANCE} of the CPU's logits: {'yes' if good else 'NO'}."]
    if not arguments.no_chain:
        said = chain(arguments.device)
        good &= all(" 0 different" in line for line in said)
        lines += ["", *said]
    page = "\n".join(lines) + "\n"
    if arguments.out:
        arguments.out.write_text(page)
    print(page)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
