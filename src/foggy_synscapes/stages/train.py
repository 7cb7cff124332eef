"""train: a network learns from the list of a row; the snapshot with the lowest validation loss becomes its model."""

import argparse
import os
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tqdm import tqdm

from foggy_synscapes.datasets.pairs import PairDataset
from foggy_synscapes.datasets.uris import Reader
from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.io.atomic import write_bytes
from foggy_synscapes.io.files import LARGEST_WEIGHTS, read_bytes
from foggy_synscapes.io.tables import write_csv
from foggy_synscapes.jobs import Job
from foggy_synscapes.labels import CLASSES
from foggy_synscapes.networks import NETWORKS
from foggy_synscapes.params import BASELINE, Params, load
from foggy_synscapes.params.training import NetworkSettings
from foggy_synscapes.provenance.runs import Run
from foggy_synscapes.results import FOG, LOGS, roots
from foggy_synscapes.steps import job
from foggy_synscapes.training.live import Live

if TYPE_CHECKING:
    import numpy as np

    from foggy_synscapes.networks.weights import Model
    from foggy_synscapes.training.policy import Duration, Policy
    from foggy_synscapes.training.ranks import Ranks

HELP = "Train a network on a row's list, from its own weights or from the baseline; goes on where it was interrupted."
NO_WEIGHTS = "none"
LAUNCHED = ("RANK", "WORLD_SIZE", "LOCAL_RANK", "MASTER_ADDR", "MASTER_PORT")
"""What torchrun tells the processes that it starts."""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this step."""
    parser.add_argument("--network", required=True, help="network to train, with settings in the section train")
    parser.add_argument("--row", required=True, help="row of the tables, e.g. FS-498: a key of the section subset")
    parser.add_argument("--seed", required=True, help="whole number from which all random choices follow, e.g. 0")


def run(args: argparse.Namespace) -> None:
    """Run the step from the command line, alone or as one of the processes that torchrun started."""
    if not all(name in os.environ for name in LAUNCHED):
        _run(args)
        return
    from foggy_synscapes.training.ranks import joined

    with joined() as ranks:
        _run(args, ranks)


def _run(args: argparse.Namespace, ranks: "Ranks | None" = None) -> None:
    params = load(args.params)
    rows = [*params.train.from_weights, *params.train.from_baseline]
    if args.row not in rows:
        raise UsageError(f"--row {args.row}: not in the params section train; it has {', '.join(rows)}")
    networks = params.train.settings
    if args.network not in networks:
        raise UsageError(f"--network {args.network}: not in the params section train; it has {', '.join(networks)}")
    if not args.seed.isascii() or not args.seed.isdigit():
        raise UsageError(f"--seed {args.seed}: expected a whole number from 0")
    train(params, args.network, args.row, args.seed, ranks)


def train(params: Params, network: str, row: str, seed: str, ranks: "Ranks | None" = None) -> None:
    """Write `model.safetensors`, `curves.csv` and `run.json` to results/train/NETWORK/ROW/seed-SEED.

    A training that was cut off goes on from `snapshot.safetensors` in the same folder, to the same bytes as if it had
    not been; the snapshot is removed at the end. Of several processes (`ranks`) the first writes.

    Raises
    ------
    FoggyError
        If an image or label is missing, was changed since it was listed or is not what training needs; if the start
        weights are of another network; if the loss is no number; if the snapshot was taken with other settings.
    """
    _set_threads(params.train.threads)
    from foggy_synscapes.networks.weights import dump
    from foggy_synscapes.training import loop
    from foggy_synscapes.training.forward import Arithmetic
    from foggy_synscapes.training.ranks import ALONE

    ranks = ranks or ALONE
    settings = params.train.network(network)
    policy = params.train.policy(network, row)
    schedule = params.train.rows[row] or settings.baseline
    if policy is None or schedule is None:
        if ranks.first:
            _take_weights(params, settings, network, row, seed)
        return
    this = job(params, "train", network=network, row=row, seed=seed)
    model = _start(settings, network, _start_file(this), int(seed))
    run = Run(this)
    reader, budget = Reader(roots(params), FOG), params.train.cache * 2**20
    training = PairDataset(this.input("train"), reader, budget, _composite)
    # Only the first process validates.
    rest = budget - training.held
    validation = PairDataset(this.input("validation"), reader, rest, _composite) if ranks.first else None
    snapshot = this.output("model").with_name("snapshot.safetensors")
    earlier = read_bytes(snapshot, "snapshot", limit=LARGEST_WEIGHTS) if snapshot.exists() else None
    if earlier and ranks.first:
        print(f"train {network} {row}: going on from {snapshot}")
    live = Live(params.train.live if ranks.first else [], Path(LOGS), f"{network}/{row}/seed-{seed}")
    with _explained(network, row, policy, snapshot), closing(live):
        plan = _plan(params, schedule.length, schedule.validate_, training.count, policy.batch, int(seed))
        ranks.take_device(params.train.device)
        asked = params.train
        arithmetic = Arithmetic(asked.device, asked.precision, asked.memory_format, asked.compile)
        # Code and libraries too: weights must not come half from one version of the loss and half from another.
        identity = {**run.identity(), "seed": seed, "processes": ranks.count}
        quiet = None if ranks.first else True
        label, total = f"train {network} {row}", plan.steps * policy.batch
        with tqdm(desc=label, unit="image", total=total, disable=quiet) as bar:
            outcome = loop.train(
                model.network,
                model.preprocessing,
                policy,
                plan,
                arithmetic,
                training,
                validation,
                save=lambda data: write_bytes(snapshot, data),
                settings=identity,
                snapshot=earlier,
                report=_reporter(bar, policy.batch),
                record=lambda values: live.write(values[0], _named(values)),
                ranks=ranks,
            )
    if not ranks.first:
        return
    model.network.load_state_dict(outcome.best)
    weights = dump(model.network, model.preprocessing)
    _finish(run, weights, outcome.curve, ranks.count)
    snapshot.unlink(missing_ok=True)
    print(
        f"train {network} {row}: {plan.steps} iterations, validation loss {outcome.best_loss:.3f} "
        f"after iteration {outcome.best_step} (kept)"
    )


@contextmanager
def _explained(network: str, row: str, policy: "Policy", snapshot: Path) -> Iterator[None]:
    """Say of an error what to do about it."""
    from foggy_synscapes.training.snapshots import SnapshotError

    try:
        yield
    except SnapshotError as error:
        raise FoggyError(
            f"{snapshot}: {error}. Restore what the training began with to go on, or delete the file to begin anew."
        ) from error
    except ValueError as error:
        raise FoggyError(f"{network} {row}: {error}") from error
    except RuntimeError as error:
        if type(error).__module__.startswith(("torch._dynamo", "torch._inductor")):
            text = " ".join(str(error).split())[:300]
            raise FoggyError(f"{network} {row}: torch.compile: {text} Set train.compile to false.") from error
        if "memory" not in str(error):
            raise
        raise FoggyError(
            f"{network} {row}: not enough memory for batches of {policy.batch} crops of {policy.crop[0]} x "
            f"{policy.crop[1]} pixels. Raise train.{network}.*.accumulate, or lower batch or crop."
        ) from error


def _named(values: list[float | int | None]) -> dict[str, float]:
    """A row of the curve by the names under which people look for it; without what was not taken."""
    names = ("epoch", "learning_rate", "train/loss", "validation/loss", "validation/miou")
    return {name: value for name, value in zip(names, values[1:], strict=True) if value is not None}


def _take_weights(params: Params, settings: NetworkSettings, network: str, row: str, seed: str) -> None:
    """Make the start weights themselves the model of a row: a public model that needs no training here."""
    from foggy_synscapes.networks.weights import dump

    weights = params.train.weights(network, row)
    model = _start(settings, network, weights, int(seed), whole=True)
    run = Run(job(params, "train", network=network, row=row, seed=seed), [weights])
    _finish(run, dump(model.network, model.preprocessing), [])
    print(f"train {network} {row}: the model is {weights}; its params say that it is not trained")


def _finish(run: Run, model: bytes, curve: list, processes: int = 1) -> None:
    """Write the model, its curve and the run record."""
    from foggy_synscapes.training.loop import CURVE

    write_bytes(run.job.output("model"), model)
    write_csv(run.job.output("curves"), CURVE, curve)
    run.finish(processes=processes)


def _start_file(job: Job) -> Path | str:
    """The baseline's model, or the file of start weights that the params name, or none."""
    if "start" in job.step.inputs:
        return job.input("start")
    return job.params.train.weights(job.values["network"], job.values["row"])


def _composite(recipe: bytes, read: Callable[[str, str], bytes], name: str) -> "np.ndarray":
    """The foggy image of a recipe; the code of fog is loaded only where a list names one."""
    from foggy_synscapes.frames.compositing import composite

    return composite(recipe, read, name)


def _set_threads(threads: int) -> None:
    """Pin the number of threads, which is part of what makes the bytes, before and after PyTorch is imported."""
    for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ[name] = str(threads)
    import torch

    torch.set_num_threads(threads)
    torch.use_deterministic_algorithms(True)
    # Filling new memory would only hide reads of it, which these operations do not make, and costs time.
    torch.utils.deterministic.fill_uninitialized_memory = False  # type: ignore[attr-defined]  # not in PyTorch's types


def _start(settings: NetworkSettings, network: str, start: Path | str, seed: int, whole: bool = False) -> "Model":
    """The network with its start weights: random ones of the seed, or those of a file; `whole`: no random ones."""
    from foggy_synscapes.networks.build import build
    from foggy_synscapes.networks.weights import Model, Preprocessing, load_start
    from foggy_synscapes.training.streams import seed_torch

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


def _plan(params: Params, length: "Duration", validate: "Duration", images: int, batch: int, seed: int) -> Any:
    from foggy_synscapes.training.loop import Plan

    return Plan(
        steps=length.steps(images, batch),
        validate_every=validate.steps(images, batch),
        curve_every=params.train.curve,
        snapshot_every=params.train.snapshot,
        seed=seed,
        workers=params.train.workers,
    )


def _reporter(bar: tqdm, batch: int) -> Callable[[int, float, float], None]:
    def report(done: int, loss: float, rate: float) -> None:
        bar.set_postfix({"loss": f"{loss:.3f}", "rate": f"{rate:.2e}"}, refresh=False)
        bar.update(done * batch - bar.n)

    return report
