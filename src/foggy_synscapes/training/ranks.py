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
from torch import Tensor
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
        """Let each process of a machine compute on a GPU of its own where `device` is "cuda".

        Raises RanksError if the machine has fewer.
        """
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
