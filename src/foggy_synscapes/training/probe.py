"""Which arithmetic trains faster on this machine: measured on the training's own first batch."""

import copy
import math
import statistics
import time
from collections.abc import Sequence

import torch

from foggy_synscapes.networks.network import Network
from foggy_synscapes.networks.weights import Preprocessing
from foggy_synscapes.training.forward import Arithmetic
from foggy_synscapes.training.loader import Samples, Steps
from foggy_synscapes.training.policy import Policy, parameter_groups, set_training
from foggy_synscapes.training.ranks import ALONE, Ranks
from foggy_synscapes.training.step import Learner, take_step

STEPS = 5
"""Steps that are measured of each arithmetic, after one that is not; their median counts."""
LESS_EXACT = 1.1
"""How many times faster bfloat16 must be to be chosen."""


def fastest(
    network: Network,
    preprocessing: Preprocessing,
    policy: Policy,
    candidates: Sequence[Arithmetic],
    samples: Samples,
    seed: int,
    ranks: Ranks = ALONE,
) -> tuple[Arithmetic, str]:
    """The arithmetic with the shortest step, and what was measured, in words; the network stays as it is.

    Several processes take the steps together and choose by the sum of their times, so all choose alike.
    """
    times = []
    for candidate in candidates:
        own = seconds(copy.deepcopy(network), preprocessing, policy, candidate, samples, seed, ranks)
        times.append(float(ranks.total(torch.tensor(own, dtype=torch.float64))) / ranks.count)
    costs = [
        spent * (LESS_EXACT if candidate.precision == "bfloat16" else 1)
        for candidate, spent in zip(candidates, times, strict=True)
    ]
    chosen = candidates[costs.index(min(costs))]
    found = ", ".join(
        f"{each.precision} {each.memory_format} {1000 * spent:.1f} ms"
        for each, spent in zip(candidates, times, strict=True)
    )
    told = f"a step takes with {found} (median of {STEPS}); chosen: {chosen.precision} {chosen.memory_format}"
    if any(candidate.precision == "bfloat16" for candidate in candidates):
        told += f". bfloat16, being less exact, must be {LESS_EXACT:g} times as fast"
    return chosen, told


def seconds(
    network: Network,
    preprocessing: Preprocessing,
    policy: Policy,
    arithmetic: Arithmetic,
    samples: Samples,
    seed: int,
    ranks: Ranks,
) -> float:
    """Median time of a step, which trains the network; infinite where the loss is no number."""
    arithmetic.place(network)
    set_training(network, policy)
    optimiser = torch.optim.SGD(parameter_groups(network, policy), lr=0.0, momentum=policy.momentum)
    learner = Learner(network, ranks, compiled=False)
    batch = Steps(samples, policy, seed, 0, 1, ranks)[0]
    spent = []
    for _ in range(STEPS + 1):
        begin = time.perf_counter()
        loss = take_step(network, learner, preprocessing, policy, arithmetic, optimiser, batch, ranks)
        if arithmetic.device == "cuda":
            torch.cuda.synchronize()
        spent.append(time.perf_counter() - begin)
        if not math.isfinite(loss):
            return math.inf
    return statistics.median(spent[1:])
