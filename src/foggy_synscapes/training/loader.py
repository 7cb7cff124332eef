"""Batches of augmented samples, from this process or from loader workers: the same either way."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import torch
from torch import Tensor
from torch.utils.data import DataLoader, Dataset

from foggy_synscapes.training.augment import augment
from foggy_synscapes.training.order import batch_indices
from foggy_synscapes.training.policy import Policy
from foggy_synscapes.training.ranks import ALONE, Ranks
from foggy_synscapes.training.streams import generator

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


class Steps(Dataset):
    """Item i is the batch of step `first` + i: a pure function of the seed and of the step."""

    def __init__(
        self, samples: Samples, policy: Policy, seed: int, first: int, last: int, ranks: Ranks = ALONE
    ) -> None:
        self.samples, self.policy, self.seed = samples, policy, seed
        self.first, self.last = first, last
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
        return collate([image for image, _ in parts], [labels for _, labels in parts], indices)


def collate(images: list[np.ndarray], labels: list[np.ndarray], indices: list[int]) -> Batch:
    """A batch of images and label maps of one size; the images keep their pixel-by-pixel layout in memory."""
    stacked = torch.from_numpy(np.stack(images)).permute(0, 3, 1, 2)
    return Batch(stacked, torch.from_numpy(np.stack(labels)), indices)


def batches(steps: Steps, workers: int, pinned: bool = False) -> Iterator[Batch]:
    """The batches in order; `workers` processes load ahead, 0 loads in this process.

    pinned : put them in page-locked memory, from which CUDA copies faster
    """
    if workers == 0:
        for item in range(len(steps)):
            yield steps[item]
        return
    loader = DataLoader(
        Carried(steps),
        batch_size=None,
        num_workers=workers,
        pin_memory=pinned,
        worker_init_fn=_one_thread,
        # The loader draws a seed for its workers; it must not draw from the generator that dropout uses.
        generator=torch.Generator(),
    )
    for batch in loader:
        if isinstance(batch, Exception):
            raise batch
        yield batch


class Carried(Dataset):
    """Items of a data set, or the error instead: raised in a worker, its message would drown in a traceback."""

    def __init__(self, steps: Steps) -> None:
        self.steps = steps

    def __len__(self) -> int:
        return len(self.steps)

    def __getitem__(self, item: int) -> Batch | Exception:
        try:
            return self.steps[item]
        except Exception as error:
            return error


def _one_thread(_worker: int) -> None:
    torch.set_num_threads(1)
