"""Which samples a step takes: a pure function of the seed and of the step."""

from functools import lru_cache

import numpy as np

from foggy_synscapes.training.streams import generator


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
