"""Batches of samples, from this process or from loader workers: the same either way."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
import torch
from torch import Tensor
from torch.utils.data import DataLoader, Dataset

from foggy_synscapes.training.augment import augment
from foggy_synscapes.training.policy import Policy
from foggy_synscapes.training.ranks import ALONE, Ranks
from foggy_synscapes.training.streams import batch_indices, generator

Sample = tuple[np.ndarray, np.ndarray]  # image uint8 (H, W, 3) and labels uint8 (H, W), trainIds


class Samples(Protocol):
    """What to learn from: samples by index below `count`, and their names for messages."""

    count: int

    def load(self, index: int) -> Sample: ...

    def name(self, index: int) -> str: ...


@dataclass(frozen=True)
class Batch:
    """Images uint8 (B, 3, H, W) in RGB order, labels uint8 (B, H, W) as trainIds, and the samples' indices.

    Where several processes share a step, the images and labels are this process's, the indices those of the whole step.
    """

    images: Tensor
    labels: Tensor
    indices: list[int]

    def pin_memory(self) -> "Batch":
        """The batch in page-locked memory, from which CUDA copies while it computes; called by PyTorch's loader."""
        return replace(self, images=self.images.pin_memory(), labels=self.labels.pin_memory())


def collate(samples: list[Sample], indices: list[int]) -> Batch:
    """A batch of samples of one size; the images keep their pixel-by-pixel layout in memory."""
    images, labels = (torch.from_numpy(np.stack(arrays)) for arrays in zip(*samples, strict=True))
    return Batch(images.permute(0, 3, 1, 2), labels, indices)


class Steps(Dataset):
    """Item i is the batch of step `first` + i: a pure function of the seed and of the step."""

    def __init__(
        self, samples: Samples, policy: Policy, seed: int, first: int, last: int, ranks: Ranks = ALONE
    ) -> None:
        self.samples, self.policy, self.seed, self.first, self.last = samples, policy, seed, first, last
        self.places = ranks.places(policy.batch, policy.accumulate)

    def __len__(self) -> int:
        return self.last - self.first

    def __getitem__(self, item: int) -> Batch:
        if not 0 <= item < len(self):
            raise IndexError(item)
        step, policy = self.first + item, self.policy
        indices = batch_indices(self.seed, step, self.samples.count, policy.batch)
        parts = []
        for place in self.places:
            random = generator(self.seed, "augment", step, place)
            sample = self.samples.load(indices[place])
            parts.append(augment(*sample, policy.crop, policy.scale, policy.flip, random, policy.class_balance))
        return collate(parts, indices)


class Whole(Dataset):
    """Item i is sample i as it is."""

    def __init__(self, samples: Samples) -> None:
        self.samples = samples

    def __len__(self) -> int:
        return self.samples.count

    def __getitem__(self, item: int) -> Batch:
        if not 0 <= item < len(self):
            raise IndexError(item)
        return collate([self.samples.load(item)], [item])


def ahead(items: Dataset, workers: int, pinned: bool = False) -> Iterable[Batch]:
    """The items in order, as often as they are asked for; `workers` processes load ahead, 0 loads in this process.

    pinned : put them in page-locked memory, from which CUDA copies faster
    """
    if workers == 0:
        return items  # type: ignore[return-value]  # PyTorch's type says nothing of what indexing alone gives
    loader = DataLoader(
        Carried(items),
        batch_size=None,
        num_workers=workers,
        pin_memory=pinned,
        persistent_workers=True,
        worker_init_fn=_one_thread,
        # The loader draws a seed for its workers; it must not draw from the generator that dropout uses.
        generator=torch.Generator(),
    )
    return Raised(loader)


def _one_thread(_worker: int) -> None:
    torch.set_num_threads(1)


class Carried(Dataset):
    """Items of a data set, or the error instead: raised in a worker, its message would drown in a traceback."""

    def __init__(self, items: Dataset) -> None:
        self.items = items

    def __len__(self) -> int:
        return len(self.items)  # type: ignore[arg-type]

    def __getitem__(self, item: int) -> Batch | Exception:
        try:
            return self.items[item]
        except Exception as error:
            return error


class Raised:
    """What workers carried; an error among it is raised here."""

    def __init__(self, loader: DataLoader) -> None:
        self.loader = loader

    def __iter__(self) -> Iterator[Batch]:
        for batch in self.loader:
            if isinstance(batch, Exception):
                raise batch
            yield batch


def groups(batches: Iterable[Batch], size: int) -> Iterator[Batch]:
    """Neighbours of one size of image put together, at most so many."""
    held: list[Batch] = []
    for batch in batches:
        if held and (len(held) == size or batch.images.shape != held[0].images.shape):
            yield _joined(held)
            held = []
        held.append(batch)
    yield _joined(held)


def _joined(held: list[Batch]) -> Batch:
    images, labels = torch.cat([each.images for each in held]), torch.cat([each.labels for each in held])
    return Batch(images, labels, [index for each in held for index in each.indices])
