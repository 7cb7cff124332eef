"""What training on more images costs: a few steps are measured, the whole follows by counting."""

import itertools
import statistics
import time
from collections.abc import Sequence
from dataclasses import dataclass

import pandas as pd

from foggy_synscapes.networks import NETWORKS
from foggy_synscapes.networks.weights import Model
from foggy_synscapes.tables.table import MISSING, signed
from foggy_synscapes.training import loop
from foggy_synscapes.training.learner import Arithmetic
from foggy_synscapes.training.loader import Sample, Samples
from foggy_synscapes.training.policy import Policy

# Columns of the CSV file, and their heads where people read them.
COSTS = {
    "network": "Network",
    "row": "Row",
    "images": "Images",
    "iterations": "Iterations",
    "cpu_seconds_per_iteration": "CPU s per iteration",
    "cpu_minutes": "CPU minutes",
    "miou": "mIoU",
}


@dataclass(frozen=True)
class Cost:
    """A fine-tuning: images, iterations, CPU seconds of a measured iteration, mean IoU (None where not scored)."""

    network: str
    row: str
    images: int
    iterations: int
    seconds: float
    miou: float | None

    @property
    def minutes(self) -> float:
        """CPU minutes of all iterations, if all take as long as those measured; validation is not counted."""
        return self.iterations * self.seconds / 60


class First:
    """One sample of a list: a validation that takes no time."""

    count = 1

    def __init__(self, samples: Samples) -> None:
        self._samples = samples

    def load(self, index: int) -> Sample:
        return self._samples.load(index)

    def name(self, index: int) -> str:
        return self._samples.name(index)


def seconds_per_step(model: Model, policy: Policy, arithmetic: Arithmetic, samples: Samples, steps: int) -> float:
    """Median CPU seconds of an iteration of the training loop, after one that is not counted; weights are changed."""
    times = [time.process_time()]
    plan = loop.Plan(steps + 2, steps + 2, steps + 2, steps + 2, seed=0, workers=0)
    loop.train(
        model, policy, plan, arithmetic, samples, First(samples),
        save=lambda data: None, settings={}, report=lambda *_: times.append(time.process_time()),
    )  # fmt: skip
    # The first step finds its memory, the last is followed by a validation.
    return statistics.median(after - before for before, after in itertools.pairwise(times[1:-1]))


def table(measured: Sequence[Cost]) -> pd.DataFrame:
    """One line of text per fine-tuning, by `COSTS`."""
    lines = [
        (one.network, one.row, str(one.images), str(one.iterations), f"{one.seconds:.3f}", f"{one.minutes:.2f}",
         MISSING if one.miou is None else f"{one.miou:.2f}")
        for one in measured
    ]  # fmt: skip
    return pd.DataFrame(lines, columns=list(COSTS))


def caption(steps: int, test_set: str) -> str:
    """What the table shows, and how its times came about."""
    return (
        f"Fine-tuning on few and on many images of Foggy Synscapes: CPU time of {steps} measured iterations, "
        f"extrapolated to all of them without validation, and mean IoU on {test_set}."
    )


def paragraph(costs: list[Cost]) -> str:
    """What the longer training buys, in words that follow from the figures."""
    text = []
    for network in dict.fromkeys(cost.network for cost in costs):
        own = sorted((cost for cost in costs if cost.network == network), key=lambda cost: cost.images)
        less, more = own[0], own[-1]
        if less is more:
            continue
        bought = (
            "one of them was not scored"
            if less.miou is None or more.miou is None
            else f"mean IoU changes by {signed(more.miou - less.miou, 2)} points, of one seed and without an interval"
        )
        text.append(
            f"{NETWORKS[network].title}: {more.row} ({more.images:,} images) takes "
            f"{more.minutes / less.minutes:.1f} times as long as {less.row} ({less.images:,}); {bought}."
        )
    return " ".join(text)
