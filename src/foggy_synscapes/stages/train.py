"""train: a network learns from the list of a row; the snapshot with the lowest validation loss becomes its model."""

import argparse
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import replace
from functools import wraps
from pathlib import Path
from typing import Any

import torch

from foggy_synscapes.datasets.pairs import PairDataset
from foggy_synscapes.datasets.uris import Reader
from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.frames.compositing import composite
from foggy_synscapes.io.atomic import write_bytes
from foggy_synscapes.io.files import LARGEST_WEIGHTS, read_bytes
from foggy_synscapes.io.progress import Progress
from foggy_synscapes.io.tables import GrowingTable, write_csv
from foggy_synscapes.labels import CLASSES
from foggy_synscapes.networks import NETWORKS
from foggy_synscapes.networks.device import take
from foggy_synscapes.networks.network import build
from foggy_synscapes.networks.weights import Model, Preprocessing, dump, load_start
from foggy_synscapes.params import BASELINE, Params, load
from foggy_synscapes.params.training import NetworkSettings
from foggy_synscapes.provenance.runs import Run
from foggy_synscapes.results import FOG, LOGS, roots
from foggy_synscapes.steps import job
from foggy_synscapes.training import loop
from foggy_synscapes.training.learner import Arithmetic
from foggy_synscapes.training.live import Live
from foggy_synscapes.training.policy import Policy
from foggy_synscapes.training.ranks import ALONE, Ranks, joined
from foggy_synscapes.training.snapshots import SnapshotError
from foggy_synscapes.training.streams import seed_torch

HELP = "Train a network on a row's list, from its own weights or from the baseline; goes on where it was interrupted."
NO_WEIGHTS = "none"
LAUNCHED = ("RANK", "WORLD_SIZE", "LOCAL_RANK", "MASTER_ADDR", "MASTER_PORT")
"""What torchrun tells the processes that it starts."""
WATCHED = ("epoch", "learning_rate", "train/loss", "validation/loss", "validation/miou")
"""Names of a curve's values, after the step, under which people look for them."""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this step."""
    parser.add_argument("--network", required=True, help="network to train, with settings in the section train")
    parser.add_argument("--row", required=True, help="row of the tables, e.g. FS-498: a key of the section subset")
    parser.add_argument("--seed", required=True, help="whole number from which all random choices follow, e.g. 0")


def run(args: argparse.Namespace) -> None:
    """Run the step from the command line, alone or as one of the processes that torchrun started."""
    params = load(args.params)
    rows = [*params.train.from_weights, *params.train.from_baseline]
    for option, value, known in (("row", args.row, rows), ("network", args.network, params.train.settings)):
        if value not in known:
            raise UsageError(f"--{option} {value}: not in the params section train; it has {', '.join(known)}")
    if not args.seed.isascii() or not args.seed.isdigit():
        raise UsageError(f"--seed {args.seed}: expected a whole number from 0")
    if all(name in os.environ for name in LAUNCHED):
        with joined() as ranks:
            train(params, args.network, args.row, args.seed, ranks)
    else:
        train(params, args.network, args.row, args.seed)


class _PutAside(Exception):
    """A snapshot was of no use."""


def _begun_anew(train: Callable[..., None]) -> Callable[..., None]:
    """Begin again where a snapshot was put aside: one command is enough after an edit of what a killed training did."""

    @wraps(train)
    def begun(*arguments: Any, **named: Any) -> None:
        try:
            train(*arguments, **named)
        except _PutAside:
            begun(*arguments, **named)

    return begun


@_begun_anew
def train(params: Params, network: str, row: str, seed: str, ranks: Ranks = ALONE) -> None:
    """Write `model.safetensors`, `curves.csv` and `run.json` to results/train/NETWORK/ROW/seed-SEED.

    A training that was cut off goes on from `snapshot.safetensors` in the same folder, to the same bytes as if it had
    not been; the snapshot is removed at the end. Of several processes (`ranks`) the first writes.

    Raises FoggyError if an image or label is missing, was changed since it was listed or is not what training needs; if
    the start weights are of another network; if the loss is no number. A snapshot of other settings is put aside.
    """
    asked = params.train
    settings, policy = asked.network(network), asked.policy(network, row)
    schedule = asked.schedule(network, row)
    this = job(params, "train", network=network, row=row, seed=seed)
    label = f"train {network} {row}"
    if policy is None or schedule is None:
        if ranks.first:
            weights = asked.weights(network, row)
            # A public model that needs no training here.
            _finish(Run(this, [weights]), _start(settings, network, weights, int(seed), whole=True))
            print(f"{label}: the model is {weights}; its params say that it is not trained")
        return
    start = this.input("start") if "start" in this.step.inputs else asked.weights(network, row)
    run = Run(this)
    model = _start(settings, network, start, int(seed))
    reader, budget = Reader(roots(params), FOG), asked.cache * 2**20
    training = PairDataset(this.input("train"), reader, budget, composite)
    # Only the first process validates.
    rest = budget - training.held
    validation = PairDataset(this.input("validation"), reader, rest, composite) if ranks.first else None
    snapshot = this.output("model").with_name("snapshot.safetensors")
    earlier = read_bytes(snapshot, "snapshot", limit=LARGEST_WEIGHTS) if snapshot.exists() else None
    if earlier and ranks.first:
        print(f"{label}: going on from {snapshot}", flush=True)
    place = f"{network}/{row}/seed-{seed}"
    live = Live(asked.live if ranks.first else [], Path(LOGS), place)
    # While it is trained, its curve is no result but there for people.
    watched = Path(LOGS, "train", place, "curves.csv") if ranks.first else Path(os.devnull)
    curve = GrowingTable(watched, loop.CURVE)

    def record(values: list) -> None:
        curve.add(values)
        live.write(values[0], dict(zip(WATCHED, values[1:], strict=True)))

    with _explained(network, row, policy, snapshot), closing(live), closing(curve):
        plan = loop.Plan(
            steps=schedule.length.steps(training.count, policy.batch),
            validate_every=schedule.validate_.steps(training.count, policy.batch),
            curve_every=asked.curve,
            snapshot_every=asked.snapshot,
            seed=int(seed),
            workers=asked.workers,
        )
        device = take(params.device_of("train"), asked.threads, **params.gpu.model_dump())
        ranks.take_device(device)
        if ranks.first:
            print(f"{label}: its curve so far is {watched}", flush=True)
        with _shown(label, plan.steps, policy.batch, ranks.first) as report:
            outcome = loop.train(
                model,
                policy,
                plan,
                Arithmetic(device, asked.precision, asked.memory_format, asked.compile),
                training,
                validation,
                save=lambda data: write_bytes(snapshot, data),
                # Code and libraries too: weights must not come half from one version of the loss, half from another.
                settings={**run.identity(), "seed": seed, "processes": ranks.count},
                snapshot=earlier,
                report=report,
                record=record,
                ranks=ranks,
            )
    if not ranks.first:
        return
    model.network.load_state_dict(outcome.best)
    _finish(run, model, outcome.curve, ranks.count, device)
    snapshot.unlink(missing_ok=True)
    print(
        f"{label}: {plan.steps} iterations, validation loss {outcome.best_loss:.3f} after iteration "
        f"{outcome.best_step} (kept); waited for images {outcome.waited:.1%} of the time"
    )


@contextmanager
def _explained(network: str, row: str, policy: Policy, snapshot: Path) -> Iterator[None]:
    """Say of an error what to do about it."""
    try:
        yield
    except SnapshotError as error:
        aside = Path(".foggy/aside") / snapshot
        with suppress(FileNotFoundError):  # of several processes another was first
            aside.parent.mkdir(parents=True, exist_ok=True)
            snapshot.replace(aside)
            print(f"{snapshot}: {error}; put aside as {aside}, and training begins anew", file=sys.stderr)
        raise _PutAside from error
    except ValueError as error:
        raise FoggyError(f"{network} {row}: {error}") from error
    except RuntimeError as error:
        if type(error).__module__.startswith(("torch._dynamo", "torch._inductor")):
            text = " ".join(str(error).split())[:300]
            raise FoggyError(f"{network} {row}: torch.compile: {text} Set train.compile to false.") from error
        if "CUDA error" in str(error):
            raise FoggyError(
                f"{network} {row}: the GPU failed: {str(error).splitlines()[0]}. Start again to go on from the "
                "snapshot; with CUDA_LAUNCH_BLOCKING=1 and --debug it says where."
            ) from error
        if not isinstance(error, torch.OutOfMemoryError) and "allocate memory" not in str(error):
            raise
        raise FoggyError(
            f"{network} {row}: not enough memory for batches of {policy.batch} crops of {policy.crop[0]} x "
            f"{policy.crop[1]} pixels. Raise train.{network}.*.accumulate, or lower batch or crop."
        ) from error


def _finish(run: Run, model: Model, curve: list | None = None, processes: int = 1, device: str = "cpu") -> None:
    """Write the model, its curve and the run record."""
    write_bytes(run.job.output("model"), dump(model.network, model.preprocessing))
    write_csv(run.job.output("curves"), loop.CURVE, curve or [])
    run.finish(processes=processes, device=device)


def _start(settings: NetworkSettings, network: str, start: Path | str, seed: int, whole: bool = False) -> Model:
    """The network with its start weights: random ones of the seed, or those of a file; `whole`: no random ones."""
    sizes = {name: getattr(settings, name) for name in ("backbone", "width", "decoder")}
    config = replace(NETWORKS[network].published, classes=len(CLASSES), **sizes)
    # What the start weights lack, or all of them, is drawn from the seed.
    seed_torch(seed, "start")
    if start == NO_WEIGHTS:
        return Model(build(config), Preprocessing())
    try:
        advice = f"Train row {BASELINE} first, or import them."
        return load_start(read_bytes(start, "file of start weights", advice, LARGEST_WEIGHTS), config, whole)
    except ValueError as error:
        raise FoggyError(f"{start}: {error}") from error


@contextmanager
def _shown(label: str, steps: int, batch: int, shown: bool) -> Iterator[Callable[[int, float, float], None]]:
    """What takes the steps done, the loss and the learning rate, and shows how far the training is."""
    bar: Progress | None = None

    def report(done: int, loss: float, rate: float) -> None:
        nonlocal bar
        if not shown:
            return
        if bar is None:
            # Begun after the first step: what an earlier run did is no speed of this one, nor is the start of workers.
            bar = Progress(label, steps * batch, done=done * batch)
        bar.update(done * batch, loss=f"{loss:.3f}", rate=f"{rate:.2e}")

    yield report
    if bar is not None:
        bar.close()
