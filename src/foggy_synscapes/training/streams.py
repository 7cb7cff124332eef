"""Random numbers as a pure function of the seed and of what they are for.

No generator lives on from one step to the next, so a training that was cut off goes on without one to restore, and
loader workers draw what the training process would have drawn.
"""

import numpy as np
import torch

PURPOSES = {"start": 0, "order": 1, "augment": 2, "dropout": 3}


def generator(seed: int, purpose: str, *numbers: int) -> np.random.Generator:
    """A fresh generator for one purpose at one place, such as ("augment", step, index in the batch)."""
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, PURPOSES[purpose], *numbers])))


def seed_torch(seed: int, purpose: str, *numbers: int) -> None:
    """Seed PyTorch's global generators for one purpose at one place."""
    value = int(generator(seed, purpose, *numbers).integers(2**63))
    if torch.cuda.is_available():
        torch.manual_seed(value)
    else:
        # The same without asking every other kind of device, which takes longer than a small layer.
        torch.default_generator.manual_seed(value)
