"""Ways of rendering fog: CPU time against the samples that change."""

import math
import statistics
import time
from dataclasses import dataclass

import numpy as np
import pandas as pd

from foggy_synscapes.camera import Camera
from foggy_synscapes.fog.airlight import estimate
from foggy_synscapes.io.progress import progress
from foggy_synscapes.tables.table import MISSING
from foggy_synscapes.tradeoff.fog_variants import Variant, variants
from foggy_synscapes.tradeoff.pareto import SAME_TIME, front

OURS = "compiled"

Frame = tuple[np.ndarray, np.ndarray, Camera]


@dataclass(frozen=True)
class Score:
    """A variant: CPU ms per image at all betas (NaN where emulated), changed samples in percent, changes in levels."""

    variant: Variant
    cpu_ms: float
    changed: float
    largest: int
    mean: float


def measure(frames: list[Frame], betas: list[float], repeats: int) -> list[Score]:
    """Time every variant on every frame, and compare it with the first one."""
    ways = variants()
    lights = [estimate(frame[0]).levels for frame in frames]
    references = [ways[0].way(*frame, light, betas) for frame, light in zip(frames, lights, strict=True)]
    scores = []
    for variant in progress(ways, "tradeoff", unit="variant"):
        times, changes = [], []
        for frame, light, reference in zip(frames, lights, references, strict=True):
            # The first call also compiles and warms up.
            off = np.abs(variant.way(*frame, light, betas).astype(np.int16) - reference)
            changes.append((np.count_nonzero(off), off.max(), off.sum(), off.size))
            for _ in range(repeats if variant.timed else 0):
                started = time.thread_time()
                variant.way(*frame, light, betas)
                times.append(1000 * (time.thread_time() - started))
        changed, largest, total, samples = zip(*changes, strict=True)
        cpu = statistics.median(times) if times else math.nan
        every = sum(samples)
        scores.append(Score(variant, cpu, 100 * sum(changed) / every, int(max(largest)), float(sum(total)) / every))
    return scores


def timed(scores: list[Score]) -> list[Score]:
    """The scores of the variants that were timed."""
    return [score for score in scores if not math.isnan(score.cpu_ms)]


def pareto_front(scores: list[Score]) -> list[str]:
    """Names of the variants that none beats in time and mean change (see `front`)."""
    best = front([(score.cpu_ms, score.mean) for score in timed(scores)])
    return [score.variant.name for score, kept in zip(timed(scores), best, strict=True) if kept]


def paragraph(scores: list[Score], what: str) -> str:
    """Which variant is the default and why, in words that follow from the figures."""
    named = {score.variant.name: score for score in scores}
    ours, plain = named[OURS], scores[0]
    quickest = min((score for score in timed(scores) if score.changed == 0), key=lambda score: score.cpu_ms)
    faster = [score for score in timed(scores) if SAME_TIME * score.cpu_ms < ours.cpu_ms]
    text = [
        f"Fog at {what}: the default is **{OURS}**, {ours.cpu_ms:.1f} ms of CPU time per image,",
        f"{plain.cpu_ms / ours.cpu_ms:.0f} times faster than {plain.variant.name} ({plain.cpu_ms:.0f} ms).",
    ]
    if ours.changed == 0 and quickest is ours:
        text.append("Of the variants that change no sample it is the fastest.")
    else:
        text.append(
            f"It changes {ours.changed:.2g} % of the samples; the fastest without a change is {quickest.variant.name}."
        )
    for score in faster:
        text.append(
            f"{score.variant.name} would take {score.cpu_ms:.1f} ms and change {score.changed:.2g} % of the samples, "
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
            "cpu_ms": f"{score.cpu_ms:.1f}" if timed([score]) else MISSING,
            "changed_percent": f"{score.changed:.3g}",
            "largest_change": str(score.largest),
            "mean_change": f"{score.mean:.3g}",
            "pareto": "yes" if score.variant.name in best else "",
        }
        for score in scores
    ]
    return pd.DataFrame(lines)
