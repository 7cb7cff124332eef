"""Several processes that train one network: who one is among them, and what they share.

A pass over a batch is cut into equal slices, one per process. Whatever depends on the whole batch (the number of pixels
that a loss is a mean over, the hardest of them, batch norm's statistics, dropout's mask) is made of all slices, so that
the processes together compute what one would compute on the whole batch, but for the order of additions.
"""

import hashlib
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import timedelta

import torch
import torch.distributed as distributed
from torch import Tensor, nn
from torch.distributed.nn.functional import all_reduce
from torch.distributed.rendezvous import rendezvous

from foggy_synscapes.errors import FoggyError

PATIENCE = timedelta(days=1)
"""How long the processes wait while the first one validates; torchrun ends them at once where one fails."""


class RanksError(ValueError):
    """The processes do not fit the batch, or do not agree on what they train."""


@dataclass(frozen=True)
class Ranks:
    """A process among `count`, which is 1 where there is no other; the first has `rank` 0."""

    rank: int = 0
    count: int = 1

    @property
    def first(self) -> bool:
        """Whether this process validates, writes and reports."""
        return self.rank == 0

    def take_device(self, device: str) -> None:
        """Let each process of a machine compute on a GPU of its own; RanksError if the machine has fewer."""
        if device != "cuda" or self.count == 1:
            return
        own, found = int(os.environ["LOCAL_RANK"]), torch.cuda.device_count()
        if own >= found:
            raise RanksError(f"process {own} of this machine has no GPU of its own: there are {found}. Start as many.")
        torch.cuda.set_device(own)

    def places(self, batch: int, passes: int) -> list[int]:
        """Places in the batch that are this process's, pass by pass.

        >>> [Ranks(rank, 2).places(8, 2) for rank in (0, 1)]
        [[0, 1, 4, 5], [2, 3, 6, 7]]

        Raises RanksError if the processes cannot share each pass evenly.
        """
        share, rest = divmod(batch, passes * self.count)
        if rest:
            raise RanksError(
                f"batch: {batch} images in {passes} passes (accumulate) cannot be shared evenly by {self.count} "
                f"processes. Choose a batch that is a multiple of {passes * self.count}, or fewer processes."
            )
        starts = [(number * self.count + self.rank) * share for number in range(passes)]
        return [start + place for start in starts for place in range(share)]

    def total(self, values: Tensor) -> Tensor:
        """Sum over all processes, without gradient; the values themselves where there is one process."""
        if self.count > 1:
            values = values.detach().clone()
            distributed.all_reduce(values)
        return values

    def gathered(self, values: Tensor) -> Tensor:
        """The values (N, ...) of all processes in their order, without gradient: (count * N, ...)."""
        if self.count > 1:
            parts = [torch.empty_like(values) for _ in range(self.count)]
            distributed.all_gather(parts, values.detach().contiguous())
            values = torch.cat(parts)
        return values

    def agree(self, text: str) -> None:
        """Raise RanksError unless all processes pass the same text: what each of them read to train from."""
        digest = hashlib.sha256(text.encode()).digest()[:7]
        digests = self.gathered(torch.tensor([int.from_bytes(digest)]))
        if len(set(digests.tolist())) > 1:
            raise RanksError(
                "the processes read different files, params or code. Is the project's folder, with its results, "
                "the same on all machines?"
            )


ALONE = Ranks()


def share(network: nn.Module, ranks: Ranks) -> None:
    """Replace the layers that depend on the whole batch by ones that see it; parameters and their names stay."""
    for name, layer in network.named_children():
        if isinstance(layer, nn.BatchNorm2d) and layer.training:
            # PyTorch's own runs on GPUs only.
            on_gpu = layer.weight.is_cuda
            synced = nn.SyncBatchNorm.convert_sync_batchnorm(layer) if on_gpu else SharedBatchNorm.of(layer, ranks)
            setattr(network, name, synced)
        elif isinstance(layer, nn.Dropout):
            setattr(network, name, SharedDropout(layer.p, ranks).train(layer.training))
        else:
            share(layer, ranks)


class SharedDropout(nn.Module):
    """Dropout of which every process draws the mask of the whole pass, from one seed, and takes its slice."""

    def __init__(self, probability: float, ranks: Ranks) -> None:
        super().__init__()
        self.probability, self.ranks = probability, ranks

    def forward(self, x: Tensor) -> Tensor:
        if not self.training:
            return x
        whole = x.new_empty((len(x) * self.ranks.count, *x.shape[1:]))
        layout = torch.channels_last if x.is_contiguous(memory_format=torch.channels_last) else torch.contiguous_format
        mask = whole.contiguous(memory_format=layout).bernoulli_(1 - self.probability)
        return x * mask.chunk(self.ranks.count)[self.ranks.rank] / (1 - self.probability)


class SharedBatchNorm(nn.BatchNorm2d):
    """Batch norm whose statistics are those of all processes' slices, which are of one size."""

    ranks: Ranks

    @classmethod
    def of(cls, layer: nn.BatchNorm2d, ranks: Ranks) -> "SharedBatchNorm":
        """The layer's parameters and statistics in a shared layer."""
        shared = cls(layer.num_features, layer.eps, layer.momentum, device="meta")
        shared.ranks = ranks
        shared.weight, shared.bias = layer.weight, layer.bias
        for name, buffer in layer.named_buffers():
            setattr(shared, name, buffer)
        return shared

    def forward(self, x: Tensor) -> Tensor:
        if not self.training:
            return super().forward(x)
        values = x.float() if x.dtype in (torch.bfloat16, torch.float16) else x
        count = values.numel() // values.shape[1]
        slots = values.new_zeros((self.ranks.count, 2, values.shape[1]))
        variance, mean = torch.var_mean(values, dim=(0, 2, 3), correction=0)
        # Each process fills its own row; the sum of all is every process's row, for gradients too.
        slots[self.ranks.rank] = torch.stack([mean, variance])
        means, variances = all_reduce(slots).unbind(1)
        mean = means.mean(0)
        variance = (variances + (means - mean).square()).mean(0)
        counted, kept_mean, kept_variance = self.num_batches_tracked, self.running_mean, self.running_var
        assert counted is not None
        assert kept_mean is not None
        assert kept_variance is not None
        assert self.momentum is not None
        with torch.no_grad():
            whole = count * self.ranks.count
            counted.add_(1)
            kept_mean.lerp_(mean, self.momentum)
            kept_variance.lerp_(variance * (whole / max(whole - 1, 1)), self.momentum)
        factor = self.weight * torch.rsqrt(variance + self.eps)
        column = (1, -1, 1, 1)
        return (values * factor.view(column) + (self.bias - mean * factor).view(column)).to(x.dtype)


def _failed_before(store: distributed.Store) -> bool:
    """Note in the common store that a process failed; returns whether another did before, or the store is gone."""
    try:
        return store.add("foggy/failed", 1) > 1
    except distributed.DistError:
        return True


@contextmanager
def joined() -> Iterator[Ranks]:
    """Join the processes that torchrun started; they talk by gloo, between GPUs by NCCL.

    Where several fail, only the first to do so lets its error pass; the others end with status 1 and without a word.

    Raises FoggyError if another process is lost without having said why.
    """
    store, rank, count = next(rendezvous("env://"))
    backend = "cpu:gloo,cuda:nccl" if torch.cuda.is_available() else "gloo"
    distributed.init_process_group(backend, timeout=PATIENCE, store=store, rank=rank, world_size=count)
    try:
        yield Ranks(rank, count)
        # Nobody leaves while another may still fail.
        distributed.barrier()
    except BaseException as error:
        if _failed_before(store):
            raise SystemExit(1) from None
        if isinstance(error, distributed.DistError) or "gloo" in str(error):
            raise FoggyError(f"another process was lost: {error}. Was it killed, for want of memory?") from error
        raise
    distributed.destroy_process_group()
