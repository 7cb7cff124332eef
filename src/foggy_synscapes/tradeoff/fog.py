"""Ways of rendering fog: CPU time against the samples that change."""

import statistics
import time
from dataclasses import dataclass

import numpy as np
import pandas as pd

from foggy_synscapes.camera import Camera
from foggy_synscapes.fog.airlight import estimate
from foggy_synscapes.io.progress import progress
from foggy_synscapes.tables.numbers import MISSING
from foggy_synscapes.tradeoff.fog_variants import Variant, variants
from foggy_synscapes.tradeoff.pareto import SAME_TIME, front

OURS = "compiled"

Frame = tuple[np.ndarray, np.ndarray, Camera]


@dataclass(frozen=True)
class Score:
    """A variant: CPU ms per image at all betas (None where emulated), changed samples in percent, changes in levels."""

    variant: Variant
    cpu_ms: float | None
    changed: float
    largest: int
    mean: float

    @property
    def ms(self) -> float:
        """The CPU time of a variant that was timed; ValueError of one that is emulated."""
        if self.cpu_ms is None:
            raise ValueError(f"{self.variant.name}: was not timed")
        return self.cpu_ms


def measure(frames: list[Frame], betas: list[float], repeats: int) -> list[Score]:
    """Time every variant on every frame, and compare it with the first one."""
    ways = variants()
    references = [_foggy(ways[0], frame, betas) for frame in frames]
    scores = []
    for variant in progress(ways, "tradeoff", unit="variant"):
        times, changed, largest, total, samples = [], 0, 0, 0, 0
        for frame, reference in zip(frames, references, strict=True):
            off = np.abs(_foggy(variant, frame, betas).astype(np.int16) - reference)  # also compiles and warms up
            changed, largest = changed + int((off > 0).sum()), max(largest, int(off.max()))
            total, samples = total + int(off.sum()), samples + off.size
            light = estimate(frame[0]).levels
            for _ in range(repeats if variant.timed else 0):
                started = time.thread_time()
                variant.way(*frame, light, betas)
                times.append(1000 * (time.thread_time() - started))
        cpu = statistics.median(times) if times else None
        scores.append(Score(variant, cpu, 100 * changed / samples, largest, total / samples))
    return scores


def pareto_front(scores: list[Score]) -> list[str]:
    """Names of the variants that none beats in time and mean change (see `front`)."""
    timed = [score for score in scores if score.cpu_ms is not None]
    best = front([(score.ms, score.mean) for score in timed])
    return [score.variant.name for score, kept in zip(timed, best, strict=True) if kept]


def paragraph(scores: list[Score], what: str) -> str:
    """Which variant is the default and why, in words that follow from the figures."""
    named = {score.variant.name: score for score in scores}
    ours, plain = named[OURS], scores[0]
    exact = [score for score in scores if score.cpu_ms is not None and score.changed == 0]
    quickest = min(exact, key=lambda score: score.ms)
    faster = [score for score in scores if score.cpu_ms is not None and SAME_TIME * score.ms < ours.ms]
    text = [
        f"Fog at {what}: the default is **{OURS}**, {ours.ms:.1f} ms of CPU time per image,",
        f"{plain.ms / ours.ms:.0f} times faster than {plain.variant.name} ({plain.ms:.0f} ms).",
    ]
    if ours.changed == 0 and quickest is ours:
        text.append("Of the variants that change no sample it is the fastest.")
    else:
        text.append(
            f"It changes {ours.changed:.2g} % of the samples; the fastest without a change is {quickest.variant.name}."
        )
    for score in faster:
        text.append(
            f"{score.variant.name} would take {score.ms:.1f} ms and change {score.changed:.2g} % of the samples, "
            f"by up to {score.largest}."
        )
    rough = [f"{score.variant.name} {score.changed:.2g} % (up to {score.largest})" for score in scores if score.changed]
    text.append(f"Samples that change: {'; '.join(rough)}.")
    return " ".join(text)


def table(scores: list[Score], best: list[str]) -> pd.DataFrame:
    """One line of text per variant; best : names of those on the front."""
    lines = [
        {
            "variant": score.variant.name,
            "about": score.variant.about,
            "cpu_ms": MISSING if score.cpu_ms is None else f"{score.cpu_ms:.1f}",
            "changed_percent": f"{score.changed:.3g}",
            "largest_change": str(score.largest),
            "mean_change": f"{score.mean:.3g}",
            "pareto": "yes" if score.variant.name in best else "",
        }
        for score in scores
    ]
    return pd.DataFrame(lines)


def _foggy(variant: Variant, frame: Frame, betas: list[float]) -> np.ndarray:
    return variant.way(*frame, estimate(frame[0]).levels, betas)
