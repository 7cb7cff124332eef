"""Random numbers, and the order of samples, as pure functions of the seed and of what they are for.

No generator lives on from one step to the next, so a training that was cut off goes on without one to restore, and
loader workers draw what the training process would have drawn.
"""

from functools import lru_cache

import numpy as np
import torch

PURPOSES = {"start": 0, "order": 1, "augment": 2, "dropout": 3}


def generator(seed: int, purpose: str, *numbers: int) -> np.random.Generator:
    """A fresh generator for one purpose at one place, such as ("augment", step, index in the batch)."""
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, PURPOSES[purpose], *numbers])))


def seed_torch(seed: int, purpose: str, *numbers: int) -> None:
    """Seed PyTorch's global generators for one purpose at one place."""
    # Without a GPU not by manual_seed: it asks every other kind of device, which takes longer than a small layer.
    seeded = torch.manual_seed if torch.cuda.is_available() else torch.default_generator.manual_seed
    seeded(int(generator(seed, purpose, *numbers).integers(2**63)))


def steps_per_epoch(count: int, batch: int) -> int:
    """Steps after which every sample was taken; the last batch of an epoch is filled up from the epoch's beginning.

    >>> steps_per_epoch(498, 4)  # 50 epochs are the paper's 6,250 iterations
    125

    Raises ValueError if the batch is larger than the list.
    """
    if not 1 <= batch <= count:
        raise ValueError(f"batch: {batch} images a step, but the list has {count}. Choose a smaller batch.")
    return -(-count // batch)


def batch_indices(seed: int, step: int, count: int, batch: int) -> list[int]:
    """Indices of the samples of a step (0-based); every epoch is shuffled anew, all batches are full."""
    epoch, place = divmod(step, steps_per_epoch(count, batch))
    order = _shuffled(seed, epoch, count)
    return [int(order[i % count]) for i in range(place * batch, (place + 1) * batch)]


@lru_cache(maxsize=2)
def _shuffled(seed: int, epoch: int, count: int) -> np.ndarray:
    return generator(seed, "order", epoch).permutation(count)
