"""One step of training: forward and backward passes over a batch, and the optimiser's step."""

import math
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext

import torch
from torch import Tensor, nn
from torch.nn.parallel import DistributedDataParallel

from foggy_synscapes.networks.network import Network
from foggy_synscapes.networks.weights import Preprocessing
from foggy_synscapes.training import losses
from foggy_synscapes.training.forward import Arithmetic, forward
from foggy_synscapes.training.loader import Batch
from foggy_synscapes.training.policy import Policy
from foggy_synscapes.training.ranks import Ranks
from foggy_synscapes.training.shared import share


class Outputs(nn.Module):
    """A network whose call gives the outputs that losses are made of, for wrappers that know calls only."""

    def __init__(self, network: Network) -> None:
        super().__init__()
        self.network = network

    def forward(self, images: Tensor) -> list[Tensor]:
        return self.network.outputs(images)


class Learner:
    """A network as the training loop calls it: shared by processes and compiled where that is asked for.

    Sharing replaces layers of the network, so the optimiser must have been given the parameters before, which stay.
    """

    def __init__(self, network: Network, ranks: Ranks, compiled: bool) -> None:
        self._parallel: DistributedDataParallel | None = None
        self.outputs: Callable[[Tensor], list[Tensor]] = network.outputs
        if ranks.count > 1:
            share(network, ranks)
            # Batch norm's statistics need no broadcast: every process computes the same ones.
            self._parallel = DistributedDataParallel(Outputs(network), forward_sync_buffers=False)
            self.outputs = self._parallel
        if compiled:
            self.outputs = torch.compile(Outputs(network) if self._parallel is None else self._parallel)

    def without_exchange(self) -> AbstractContextManager:
        """Within it gradients stay in their process: for all passes of a step but the last."""
        return self._parallel.no_sync() if self._parallel is not None else nullcontext()


def take_step(
    network: Network,
    learner: Learner,
    preprocessing: Preprocessing,
    policy: Policy,
    arithmetic: Arithmetic,
    optimiser: torch.optim.Optimizer,
    batch: Batch,
    ranks: Ranks,
) -> float:
    """One optimiser step; returns the loss, the mean over the passes into which the batch is split."""
    optimiser.zero_grad(set_to_none=True)
    value = 0.0
    parts = zip(batch.images.chunk(policy.accumulate), batch.labels.chunk(policy.accumulate), strict=True)
    for number, (images, labels) in enumerate(parts, start=1):
        with nullcontext() if number == policy.accumulate else learner.without_exchange():
            outputs, targets = forward(
                network, preprocessing, arithmetic, policy.loss_stride, images, labels, learner.outputs
            )
            loss = losses.total(
                outputs,
                targets,
                network.corners,
                policy.loss,
                policy.ohem_threshold,
                policy.ohem_kept,
                policy.auxiliary_weight,
                ranks,
            )
            loss = loss / policy.accumulate
            # Gradients are averaged over the processes, but the loss is the sum of their parts.
            (loss * ranks.count if ranks.count > 1 else loss).backward()
        value += float(ranks.total(loss.detach()))
    if math.isfinite(value):
        optimiser.step()
    return value
