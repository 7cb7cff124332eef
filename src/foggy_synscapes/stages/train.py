"""train: a network learns from the list of a row; the snapshot with the lowest validation loss becomes its model."""

import argparse
import os
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tqdm import tqdm

from foggy_synscapes.datasets.pairs import PairDataset
from foggy_synscapes.datasets.uris import Reader
from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.io.atomic import write_bytes
from foggy_synscapes.io.hashing import sha256
from foggy_synscapes.io.tables import write_csv
from foggy_synscapes.labels import CLASSES
from foggy_synscapes.params import Params, load, root
from foggy_synscapes.params.training import Duration, NetworkSettings
from foggy_synscapes.provenance import source_digest
from foggy_synscapes.provenance.recorded import recorded
from foggy_synscapes.provenance.runs import checked_inputs, versions, write_run
from foggy_synscapes.training.live import Live

if TYPE_CHECKING:
    import numpy as np

    from foggy_synscapes.networks.weights import Model
    from foggy_synscapes.training.forward import Arithmetic
    from foggy_synscapes.training.policy import Policy
    from foggy_synscapes.training.ranks import Ranks

HELP = "Train a network on a row's list, from its own weights or from the baseline; goes on where it was interrupted."
FOLDER = Path("results/train")
LISTS = Path("results/subset")
BASELINE = "C"
DATASETS = ("synscapes", "cityscapes", "foggy_cityscapes")
NO_WEIGHTS = "none"
MEASURED = "measured"
LAUNCHED = ("RANK", "WORLD_SIZE", "LOCAL_RANK", "MASTER_ADDR", "MASTER_PORT")
"""What torchrun tells the processes that it starts."""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this step."""
    parser.add_argument("--network", required=True, choices=["refinenet", "bisenet"], help="network to train")
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
    from foggy_synscapes.training.policy import Policy
    from foggy_synscapes.training.ranks import ALONE

    ranks = ranks or ALONE
    settings: NetworkSettings = getattr(params.train, network)
    chosen = params.train.policy(network, row)
    if chosen is None:
        if ranks.first:
            _take_weights(params, settings, network, row, seed)
        return
    policy = Policy(**chosen.model_dump(include=set(Policy.__dataclass_fields__)))
    schedule = params.train.rows[row] or settings.baseline
    folder = FOLDER / network / row / f"seed-{seed}"
    lists = {name: LISTS / row / f"{name}.csv" for name in ("train", "validation")}
    start = params.train.weights(network, row)
    if row in params.train.from_baseline:
        start = FOLDER / network / BASELINE / f"seed-{seed}" / "model.safetensors"

    model = _start(settings, network, start, int(seed))
    inputs = checked_inputs([*lists.values(), *([start] if start != NO_WEIGHTS else [])])
    reader, budget = Reader({name: root(params, name) for name in DATASETS}), params.train.cache * 2**20
    training = PairDataset(lists["train"], reader, budget, _composite)
    # Only the first process validates.
    validation = PairDataset(lists["validation"], reader, budget - training.held, _composite) if ranks.first else None
    snapshot = folder / "snapshot.safetensors"
    earlier = snapshot.read_bytes() if snapshot.exists() else None
    if earlier and ranks.first:
        print(f"train {network} {row}: going on from {snapshot}")
    live = Live(params.train.live if ranks.first else [], f"{network}/{row}/seed-{seed}")
    with _explained(network, row, policy, snapshot), closing(live):
        plan = _plan(params, schedule.length, schedule.validate_, training.count, policy.batch, int(seed))
        ranks.take_device(params.train.device)
        arithmetic, measured = _arithmetic(params, model, policy, training, network, row, int(seed), earlier, ranks)
        record = _record(params, network, row)
        # Code and libraries too: weights must not come half from one version of the loss and half from another.
        identity = {
            "code": {name: sha256(source_digest.FOLDER / name) for name in source_digest.sources("train")},
            "versions": versions("train"),
            "params": record,
            "seed": seed,
            "inputs": inputs,
            "processes": ranks.count,
            MEASURED: measured,
        }
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
    _finish(network, row, seed, weights, outcome.curve, record, inputs, ranks.count, measured)
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


def _arithmetic(
    params: Params,
    model: "Model",
    policy: "Policy",
    training: PairDataset,
    network: str,
    row: str,
    seed: int,
    earlier: bytes | None,
    ranks: "Ranks",
) -> tuple["Arithmetic", dict[str, str] | None]:
    """What to compute with; and what of it was measured, now or before an interruption, where the params ask for it."""
    from foggy_synscapes.training import probe, snapshots
    from foggy_synscapes.training.forward import Arithmetic

    asked = params.train
    if MEASURED not in (asked.precision, asked.memory_format):
        return Arithmetic(asked.device, asked.precision, asked.memory_format, asked.compile), None
    kept = snapshots.settings_of(earlier).get(MEASURED) if earlier else None
    ranks.agree(str(kept))
    if kept is None:
        precisions = ("float32", "bfloat16") if asked.precision == MEASURED else (asked.precision,)
        formats = ("channels_last", "contiguous") if asked.memory_format == MEASURED else (asked.memory_format,)
        candidates = [Arithmetic(asked.device, each, layout) for each in precisions for layout in formats]
        chosen, told = probe.fastest(model.network, model.preprocessing, policy, candidates, training, seed, ranks)
        kept = {"precision": chosen.precision, "memory_format": chosen.memory_format}
    else:
        told = f"keeps what was measured when it began: {kept['precision']} {kept['memory_format']}"
    if ranks.first:
        print(f"train {network} {row}: {told}", flush=True)
    return Arithmetic(asked.device, **kept, compile=asked.compile), kept


def _named(values: list[float | int | None]) -> dict[str, float]:
    """A row of the curve by the names under which people look for it; without what was not taken."""
    names = ("epoch", "learning_rate", "train/loss", "validation/loss", "validation/miou")
    return {name: value for name, value in zip(names, values[1:], strict=True) if value is not None}


def _take_weights(params: Params, settings: NetworkSettings, network: str, row: str, seed: str) -> None:
    """Make the start weights themselves the model of a row: a public model that needs no training here."""
    from foggy_synscapes.networks.weights import dump

    weights = params.train.weights(network, row)
    model = _start(settings, network, weights, int(seed), whole=True)
    inputs = checked_inputs([weights])
    _finish(network, row, seed, dump(model.network, model.preprocessing), [], _record(params, network, row), inputs)
    print(f"train {network} {row}: the model is {weights}; its params say that it is not trained")


def _finish(
    network: str,
    row: str,
    seed: str,
    model: bytes,
    curve: list,
    record: dict[str, Any],
    inputs: dict[str, str],
    processes: int = 1,
    measured: dict[str, str] | None = None,
) -> None:
    """Write the model, its curve and the run record."""
    from foggy_synscapes.training.loop import CURVE

    folder = FOLDER / network / row / f"seed-{seed}"
    outputs = [folder / "model.safetensors", folder / "curves.csv"]
    write_bytes(outputs[0], model)
    write_csv(outputs[1], CURVE, curve)
    write_run(
        folder / "run.json",
        command=["foggy", "train", "--network", network, "--row", row, "--seed", seed],
        params=record,
        inputs=inputs,
        outputs=outputs,
        processes=processes,
        measured=measured,
    )


def _composite(recipe: bytes, read: Callable[[str, str], bytes], name: str) -> "np.ndarray":
    """The foggy image of a recipe; the code of fog is loaded only where a list names one (`source_digest.CHECKED`)."""
    from foggy_synscapes.frames import recipes

    return recipes.composite(recipe, read, name)


def _set_threads(threads: int) -> None:
    """Pin the number of threads, which is part of what makes the bytes, before and after PyTorch is imported."""
    for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ[name] = str(threads)
    import torch

    torch.set_num_threads(threads)
    torch.use_deterministic_algorithms(True)
    # Filling new memory would only hide reads of it, which these operations do not make, and costs time.
    torch.utils.deterministic.fill_uninitialized_memory = False


def _start(settings: NetworkSettings, network: str, start: Path | str, seed: int, whole: bool = False) -> "Model":
    """The network with its start weights: random ones of the seed, or those of a file; `whole`: no random ones."""
    from foggy_synscapes.networks.build import build
    from foggy_synscapes.networks.config import NetworkConfig
    from foggy_synscapes.networks.weights import Model, Preprocessing, load_start
    from foggy_synscapes.training.streams import seed_torch

    config = NetworkConfig(
        network, settings.backbone, settings.width, settings.decoder, len(CLASSES), auxiliary=network == "bisenet"
    )
    # What the start weights lack, or all of them, is drawn from the seed.
    seed_torch(seed, "start")
    if start == NO_WEIGHTS:
        return Model(build(config), Preprocessing())
    try:
        return load_start(Path(start).read_bytes(), config, whole)
    except OSError as error:
        raise FoggyError(
            f"{start}: the start weights cannot be read: {error.strerror}. Train row {BASELINE} first, or import them."
        ) from error
    except ValueError as error:
        raise FoggyError(f"{start}: {error}") from error


def _plan(params: Params, length: Duration, validate: Duration, images: int, batch: int, seed: int) -> Any:
    from foggy_synscapes.training.loop import Plan

    return Plan(
        steps=length.steps(images, batch),
        validate_every=validate.steps(images, batch),
        curve_every=params.train.curve,
        snapshot_every=params.train.snapshot,
        seed=seed,
        workers=params.train.workers,
    )


def _record(params: Params, network: str, row: str) -> dict[str, Any]:
    """The params that decide what this training gives: not its workers or memory."""
    own = ["fine_tuning"] if row in params.train.from_baseline else ["baseline", "weights"]
    keys = ["threads", "device", "precision", "memory_format", "compile", "curve", f"rows.{row}"]
    keys += [f"{network}.{key}" for key in ("backbone", "width", "decoder", *own)]
    return recorded(params, *(f"train.{key}" for key in keys))


def _reporter(bar: tqdm, batch: int) -> Callable[[int, float, float], None]:
    def report(done: int, loss: float, rate: float) -> None:
        bar.set_postfix({"loss": f"{loss:.3f}", "rate": f"{rate:.2e}"}, refresh=False)
        bar.update(done * batch - bar.n)

    return report
