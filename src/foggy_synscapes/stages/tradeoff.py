"""tradeoff: what cheaper arithmetic for fog would save, and how many pixels it would change."""

import argparse
import statistics
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from foggy_synscapes.camera import Camera
from foggy_synscapes.datasets import synscapes
from foggy_synscapes.datasets.index import index_path, read_index
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.fog.airlight import estimate
from foggy_synscapes.fog.variants import Variant, variants
from foggy_synscapes.fogging.pipeline import KEPT, read_frame
from foggy_synscapes.io.atomic import write_bytes, write_text
from foggy_synscapes.io.runs import checked_inputs, write_run
from foggy_synscapes.io.tables import read_csv, write_csv
from foggy_synscapes.params import Params, load, root
from foggy_synscapes.progress import progress
from foggy_synscapes.recorded import recorded

HELP = "Measure variants of the fog arithmetic: CPU time against the pixels that change. Its times differ run by run."
FOLDER = Path("results/tradeoff")
COLUMNS = ("variant", "about", "cpu_ms", "changed_percent", "largest_change", "mean_change", "pareto")
OURS = "compiled"
SAME_TIME = 1.05  # times within this factor count as equal: runs differ by as much

Frame = tuple[np.ndarray, np.ndarray, Camera]


@dataclass(frozen=True)
class Score:
    """A variant: CPU ms per image at all betas (None where emulated), changed samples in percent, changes in levels."""

    variant: Variant
    cpu_ms: float | None
    changed: float
    largest: int
    mean: float


def arguments(parser: argparse.ArgumentParser) -> None:
    """This step has no options of its own."""


def run(args: argparse.Namespace) -> None:
    """Run the step from the command line."""
    tradeoff(load(args.params))


def tradeoff(params: Params) -> list[Score]:
    """Write `fog.csv`, `.tex`, `.png`, `.pdf` and `.md` to results/tradeoff, and return what was measured.

    Raises FoggyError if a frame is missing, damaged or not as indexed.
    """
    from foggy_synscapes.plotting.pareto import pareto
    from foggy_synscapes.plotting.style import render
    from foggy_synscapes.tabling.long import long_table

    inputs: dict[str, str] = {}
    frames = _frames(params, inputs)
    betas = params.tradeoff.betas
    scores = measure(frames, [float(beta) for beta in betas], params.tradeoff.repeats)
    front = pareto_front(scores)
    outputs = [FOLDER / f"fog.{ending}" for ending in ("csv", "tex", "md", "png", "pdf")]
    rows = [_row(score, score.variant.name in front) for score in scores]
    write_csv(outputs[0], COLUMNS, rows)
    height, width = frames[0][1].shape
    what = f"{len(betas)} betas, {len(frames)} images of {width} x {height} pixels"
    caption = f"Fog arithmetic: CPU time per image ({what}) and change against float64, in levels of 8 bits."
    write_text(outputs[1], long_table(COLUMNS, rows, caption, "table:tradeoff-fog"))
    write_text(outputs[2], paragraph(scores, what) + "\n")
    points = [(score.variant.name, score.cpu_ms, score.mean) for score in scores if score.cpu_ms is not None]
    figure = pareto(points, front, f"CPU ms per image, {len(betas)} betas", "mean change (levels)")
    for path in outputs[3:]:
        write_bytes(path, render(figure, path.suffix[1:]))
    write_run(
        FOLDER / "run.json",
        command=["foggy", "tradeoff"],
        params=recorded(params, "tradeoff", "scenes.roots.synscapes", "scenes.shards"),
        inputs=inputs,
        outputs=outputs,
    )
    print(f"tradeoff: {len(scores)} variants; {outputs[2]}")
    return scores


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
    """Names of the variants that none beats: as fast, within noise, with less change, or faster with as much."""
    timed = [score for score in scores if score.cpu_ms is not None]

    def beaten(one: Score) -> bool:
        return any(
            (other.cpu_ms <= SAME_TIME * one.cpu_ms and other.mean < one.mean)
            or (SAME_TIME * other.cpu_ms <= one.cpu_ms and other.mean <= one.mean)
            for other in timed
        )

    return [score.variant.name for score in timed if not beaten(score)]


def paragraph(scores: list[Score], what: str) -> str:
    """Which variant is the default and why, in words that follow from the figures."""
    named = {score.variant.name: score for score in scores}
    ours, plain = named[OURS], scores[0]
    exact = [score for score in scores if score.cpu_ms is not None and score.changed == 0]
    quickest = min(exact, key=lambda score: score.cpu_ms)
    faster = [score for score in scores if score.cpu_ms is not None and SAME_TIME * score.cpu_ms < ours.cpu_ms]
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


def _row(score: Score, best: bool) -> tuple[str, ...]:
    cpu = "--" if score.cpu_ms is None else f"{score.cpu_ms:.1f}"
    variant = score.variant
    numbers = cpu, f"{score.changed:.3g}", str(score.largest), f"{score.mean:.3g}"
    return variant.name, variant.about, *numbers, "yes" if best else ""


def _foggy(variant: Variant, frame: Frame, betas: list[float]) -> np.ndarray:
    return variant.way(*frame, estimate(frame[0]).levels, betas)


def _frames(params: Params, inputs: dict[str, str]) -> list[Frame]:
    names = [f"synscapes/{shard}" for shard in params.scenes.shards]
    inputs.update(checked_inputs([KEPT, *(index_path(name) for name in names)]))
    index, folder = read_index(*names), root(params, "synscapes")
    rows = read_csv(KEPT, ("id",))[: params.tradeoff.frames]
    if len(rows) < params.tradeoff.frames:
        raise FoggyError(f"tradeoff.frames: asks for {params.tradeoff.frames} frames, but the filter kept {len(rows)}")
    clear = [read_frame(folder, int(row["id"]), index) for row in rows]
    return [(one.image, one.depth, synscapes.camera_of(row)) for one, row in zip(clear, rows, strict=True)]
