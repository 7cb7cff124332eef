"""The training loop."""

import json
import math
from collections.abc import Callable
from dataclasses import dataclass

from torch import Tensor

from foggy_synscapes.io.ahead import Watch
from foggy_synscapes.networks.weights import Model
from foggy_synscapes.training import snapshots
from foggy_synscapes.training.learner import Arithmetic, Learner, NotFiniteError
from foggy_synscapes.training.loader import Samples, Steps, Whole, ahead, groups
from foggy_synscapes.training.policy import Policy
from foggy_synscapes.training.ranks import ALONE, Ranks
from foggy_synscapes.training.snapshots import Progress
from foggy_synscapes.training.streams import seed_torch, steps_per_epoch

CURVE = ("step", "epoch", "learning_rate", "train_loss", "validation_loss", "validation_miou")


@dataclass(frozen=True)
class Plan:
    """How long to train and how often to look.

    steps : optimiser steps; validate_every, curve_every, snapshot_every : steps between validations, rows, snapshots
    seed : of order, augmentation and dropout; workers : loader processes
    """

    steps: int
    validate_every: int
    curve_every: int
    snapshot_every: int
    seed: int
    workers: int

    def __post_init__(self) -> None:
        for name in ("steps", "validate_every", "curve_every", "snapshot_every"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name}: {getattr(self, name)}, expected at least 1")


@dataclass(frozen=True)
class Outcome:
    """The weights with the lowest validation loss, when they were reached, and the rows of the curve.

    None of these is known to a process that does not validate. waited : share of the time that steps waited for batches
    """

    best: dict[str, Tensor]
    best_step: int | None
    best_loss: float | None
    curve: list[list[float | int | None]]
    waited: float


def train(
    model: Model,
    policy: Policy,
    plan: Plan,
    arithmetic: Arithmetic,
    training: Samples,
    validation: Samples | None,
    save: Callable[[bytes], None],
    settings: dict,
    snapshot: bytes | None = None,
    report: Callable[[int, float, float], None] = lambda step, loss, rate: None,
    record: Callable[[list], None] = lambda row: None,
    ranks: Ranks = ALONE,
) -> Outcome:
    """Train a model's network in place, keep the weights of the lowest validation loss, save snapshots to go on from.

    Started again with the last snapshot and the same arguments, the outcome is the same to the last bit.

    Several processes that share a training take the samples of a step that one would take, and add up one loss and
    gradient (see `ranks`); the first validates and saves, and its outcome is the training's.

    validation : the list that snapshots are compared on; only the first process needs it
    save : takes the bytes of a snapshot; settings : plain values that identify the training, kept in it
    snapshot : bytes that `save` was given in an earlier run, or None to begin
    report : called after each step with the number of steps done, the step's loss and its learning rate
    record : called with each row of the curve, with those of earlier runs too; ranks : who shares this training

    Raises NotFiniteError if a loss is infinite or not a number; SnapshotError if the snapshot is not one of this
    training; ValueError if a batch is larger than the list, or the processes cannot share it or disagree.
    """
    epoch = steps_per_epoch(training.count, policy.batch)
    learner = Learner(model, policy, arithmetic, ranks)
    best: dict[str, Tensor] = {}
    progress = Progress()
    if snapshot is not None:
        best, progress = snapshots.restore(snapshot, learner.network, learner.optimiser, settings)
        learner.scaler.load_state_dict(progress.scaler)
        for row in progress.curve:
            record(row)
    ranks.agree(json.dumps([settings, progress.step], sort_keys=True))
    learner.wrap()
    pinned = arithmetic.device == "cuda"
    whole = ahead(Whole(validation), plan.workers, pinned) if ranks.first and validation is not None else None
    steps = Steps(training, policy, plan.seed, progress.step, plan.steps, ranks)
    watch = Watch(ahead(steps, plan.workers, pinned))
    for batch in watch:
        step = progress.step
        rate = policy.rate(step, plan.steps)
        for group in learner.optimiser.param_groups:
            group["lr"] = rate * group["factor"]
        seed_torch(plan.seed, "dropout", step)
        loss = learner.step(batch)
        if not math.isfinite(loss):
            names = ", ".join(map(training.name, batch.indices))
            raise NotFiniteError(f"loss is {loss} at step {step + 1}, on {names}. Is the learning rate too high?")
        progress.step = done = step + 1
        progress.losses = [progress.losses[0] + loss, progress.losses[1] + 1]
        last = done == plan.steps
        scores: tuple[float | None, float | None] = (None, None)
        if whole is not None and validation is not None and (done % plan.validate_every == 0 or last):
            with watch.paused():
                scores = learner.validate(groups(whole, policy.batch), validation.name)
            if progress.best_loss is None or scores[0] < progress.best_loss:
                progress.best_loss, progress.best_step = scores[0], done
                best = {name: tensor.detach().clone() for name, tensor in learner.network.state_dict().items()}
        if done % plan.curve_every == 0 or scores[0] is not None:
            mean = progress.losses[0] / progress.losses[1]
            progress.curve.append([done, done / epoch, rate, mean, *scores])
            progress.losses = [0.0, 0]
            record(progress.curve[-1])
        if ranks.first and done % plan.snapshot_every == 0 and not last:
            progress.scaler = learner.scaler.state_dict()
            save(snapshots.dump(learner.network, learner.optimiser, best, progress, settings))
        report(done, loss, rate)
    return Outcome(best, progress.best_step, progress.best_loss, progress.curve, watch.share)
