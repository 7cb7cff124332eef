"""Ways of computing a trained network: CPU time of one thread against what becomes of its scores on a test set."""

import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd
import torch

from foggy_synscapes.io.progress import progress
from foggy_synscapes.labels import CLASSES
from foggy_synscapes.networks import NETWORKS, titles
from foggy_synscapes.networks.weights import Model
from foggy_synscapes.scoring.bootstrap import in_words, interval
from foggy_synscapes.scoring.metrics import summarize
from foggy_synscapes.scoring.tally import image_matrix
from foggy_synscapes.tables.table import DASH, MISSING, signed
from foggy_synscapes.tradeoff.graph import Difference, Graph
from foggy_synscapes.tradeoff.pareto import front

NO_INTERVAL = "Of one image there is no interval, so nothing is recommended"
THREADS = 1  # that a measurement counts the time of
EAGER, BFLOAT16, ONNX, INT8 = "PyTorch float32", "PyTorch bfloat16", "ONNX float32", "ONNX int8"
WAYS = (EAGER, BFLOAT16, ONNX, INT8)

# Columns of the CSV files, and their heads where people read them; those without a head are in the CSV file alone.
BACKENDS = {
    "network": "Network",
    "scale": "Scale",
    "way": "Way",
    "cpu_ms": "CPU ms",
    "times_as_fast": "Faster",
    "miou": "mIoU",
    "change": "Change",
    "low": "From",
    "high": "To",
    "most_changed_class": "Most changed",
    "largest_logit_change": "Logits",
    "changed_percent": "Pixels (%)",
    "pareto": "Front",
}
KEYS = ["network", "scale", "way"]

Sample = tuple[np.ndarray, np.ndarray]  # image uint8 (H, W, 3), labelIds uint8 (H, W)
Outputs = tuple[np.ndarray, np.ndarray]  # logits float32 (C, H, W), trainIds uint8 (H, W)


@dataclass(frozen=True)
class Score:
    """One way of computing one network.

    scale : of the image's sides; cpu_ms : median per image, from 8-bit RGB to trainIds of its size, on `THREADS`
    matrices : int64 (N, 19, 20), the confusion matrix of each image
    largest : difference of logits from the reference; changed : pixels, in percent
    """

    network: str
    scale: float
    way: str
    cpu_ms: float
    matrices: np.ndarray = field(repr=False)
    largest: float
    changed: float

    @cached_property
    def scores(self) -> dict[str, Any]:
        """Of all images together, see `metrics.summarize`."""
        return summarize(self.matrices.sum(axis=0), len(self.matrices))

    @property
    def miou(self) -> float:
        """Mean IoU over the annotated classes, in percent."""
        return self.scores["mean_iou"]["annotated"]

    def ends(self, reference: "Score") -> tuple[float, float] | None:
        """The 95 % interval of its mean IoU less that of another way, in points; None of a single image."""
        return interval(reference.matrices, self.matrices)

    def change(self, reference: "Score") -> dict[str, float]:
        """IoU of each annotated class less that of another way, in points."""
        pairs = zip(self.scores["classes"], reference.scores["classes"], strict=True)
        return {one["name"]: one["iou"] - other["iou"] for one, other in pairs if one["iou"] is not None}


@dataclass(frozen=True)
class Backend:
    """Functions of an image: trainIds alone, which is timed, and logits with trainIds, to compare."""

    classes: Callable[[np.ndarray], np.ndarray]
    outputs: Callable[[np.ndarray], Outputs]


def measure(
    name: str, model: Model, samples: Sequence[Sample], calibration: Sequence[np.ndarray], scales: Sequence[float]
) -> list[Score]:
    """Time every way that this machine can compute, at every scale, on all samples.

    Each is compared with PyTorch in float32 at full scale.

    calibration : training images, whose ranges the 8-bit ways take
    """
    torch.set_num_threads(THREADS)
    reference = _eager(model, 1.0, torch.float32)
    scores = []
    for scale in scales:
        backends = backends_at(model, scale, calibration)
        times: dict[str, list[float]] = {way: [] for way in backends}
        matrices: dict[str, list[np.ndarray]] = {way: [] for way in backends}
        differences = {way: Difference() for way in backends}
        for rgb, labels in progress(samples, f"tradeoff {name} at {scale:g}"):
            logits = reference.outputs(rgb)[0]
            for way, run in backends.items():
                # The first call finds its memory; the second is timed.
                own, classes = run.outputs(rgb)
                differences[way].add(logits, own, classes)
                matrices[way].append(image_matrix(labels, classes))
                run.classes(rgb)
                started = time.thread_time()
                run.classes(rgb)
                times[way].append(1000 * (time.thread_time() - started))
        for way, off in differences.items():
            cpu, own = statistics.median(times[way]), np.stack(matrices[way])
            scores.append(Score(name, scale, way, cpu, own, off.largest, off.changed_percent))
    return scores


def backends_at(model: Model, scale: float, calibration: Sequence[np.ndarray]) -> dict[str, Backend]:
    """Those of `WAYS` that this machine can compute and has the packages for."""
    backends = {EAGER: _eager(model, scale, torch.float32)}
    if torch.ops.mkldnn._is_mkldnn_bf16_supported():
        backends[BFLOAT16] = _eager(model, scale, torch.bfloat16)
    try:
        from foggy_synscapes.tradeoff.onnx_export import to_int8, to_onnx

        graph = to_onnx(model, scale)
        backends[ONNX] = _session(graph)
        backends[INT8] = _session(to_int8(graph, calibration))
    except ImportError:
        # The table prints -- for them, and the text says which packages are missing.
        return backends
    return backends


def _eager(model: Model, scale: float, dtype: torch.dtype) -> Backend:
    graph = Graph(model, scale).eval()

    def outputs(rgb: np.ndarray) -> Outputs:
        with torch.inference_mode(), torch.autocast("cpu", torch.bfloat16, enabled=dtype == torch.bfloat16):
            logits, classes = graph(torch.from_numpy(rgb)[None])
        return logits[0].numpy(), classes[0].numpy()

    return Backend(lambda rgb: outputs(rgb)[1], outputs)


def _session(graph: bytes) -> Backend:
    from foggy_synscapes.tradeoff.onnx_export import Session, with_output

    whole, alone = Session(graph, THREADS), Session(with_output(graph, "classes"), THREADS)
    return Backend(lambda rgb: alone(rgb, "classes"), lambda rgb: (whole(rgb, "logits"), whole(rgb, "classes")))


def pareto_front(scores: Sequence[Score]) -> list[bool]:
    """Which ways none beats in time and mean IoU, over all networks."""
    return front([(score.cpu_ms, -score.miou) for score in scores])


def _change(score: Score, plain: Score) -> tuple[float, tuple[float, float] | None]:
    return score.miou - plain.miou, score.ends(plain)


def bars(scores: Sequence[Score]) -> list[tuple[float, float] | None]:
    """Between which mean IoUs each way lies, by the interval of its change from the reference; None for that itself."""
    found: list[tuple[float, float] | None] = []
    for score in scores:
        plain = reference_of(scores, score.network)
        ends = None if score is plain else score.ends(plain)
        found.append(None if ends is None else (plain.miou + ends[0], plain.miou + ends[1]))
    return found


def reference_of(scores: Sequence[Score], network: str) -> Score:
    """PyTorch in float32 at full scale."""
    return next(score for score in scores if (score.network, score.scale, score.way) == (network, 1.0, EAGER))


def recommended(scores: Sequence[Score], network: str, tolerance: float) -> Score:
    """The fastest way that surely loses no more points of mean IoU than are tolerated: by its interval, not its value.

    Without an interval that is the reference.
    """
    plain = reference_of(scores, network)
    good = [plain]
    for score in scores:
        ends = score.ends(plain)
        if score.network == network and ends is not None and ends[0] >= -tolerance:
            good.append(score)
    return min(good, key=lambda score: score.cpu_ms)


def affordable(models: Mapping[str, Model], image: np.ndarray, scales: Sequence[float], seconds: float) -> int:
    """How many images can be measured in so many seconds, by the time that PyTorch in float32 takes for one."""
    torch.set_num_threads(THREADS)
    each = 0.0
    for model in models.values():
        backend = _eager(model, 1.0, torch.float32)
        backend.classes(image)
        started = time.monotonic()
        backend.classes(image)
        # The reference once, and each way three times: none takes longer than PyTorch in float32.
        each += (time.monotonic() - started) * sum(1 + 3 * len(WAYS) * scale**2 for scale in scales)
    return int(seconds / each)


def paragraph(scores: Sequence[Score], tolerance: float) -> str:
    """Which way to take for each network and why, in words that follow from the figures and their intervals."""
    parts = []
    for network in dict.fromkeys(score.network for score in scores):
        plain, chosen = reference_of(scores, network), recommended(scores, network, tolerance)
        text = [
            f"{NETWORKS[network].title}: PyTorch in float32 takes {plain.cpu_ms:.1f} ms of one thread per image "
            f"and reaches a mean IoU of {plain.miou:.2f} %."
        ]
        if chosen is plain:
            known = plain.ends(plain) is not None
            why = f"No other way is faster and surely within {tolerance:g} points of that" if known else NO_INTERVAL
            text.append(f"{why}: take **{EAGER}**.")
        else:
            text.append(
                f"Take **{chosen.way}** at scale {chosen.scale:g}: {chosen.cpu_ms:.1f} ms, "
                f"{plain.cpu_ms / chosen.cpu_ms:.1f} times as fast, {signed(chosen.miou - plain.miou, 2)} points, "
                f"{chosen.changed:.2g} % of the pixels of another class; {in_words(*_change(chosen, plain))}. It is "
                f"the fastest that surely loses at most {tolerance:g} points."
            )
        text += [
            f"{score.way} at scale {score.scale:g} is {plain.cpu_ms / score.cpu_ms:.1f} times as fast at "
            f"{signed(score.miou - plain.miou, 2)} points: {in_words(*_change(score, plain))}."
            for score in scores
            if score.network == network and score.way == INT8 and score is not chosen
        ]
        parts.append(" ".join(text))
    missing = sorted({*WAYS} - {score.way for score in scores})
    if missing:
        parts.append(
            "Not measured here, for want of the processor's instructions or of the packages of the extra `export`: "
            f"{', '.join(missing)}."
        )
    return "\n\n".join(parts)


def table(scores: Sequence[Score], front: Sequence[bool]) -> pd.DataFrame:
    """One line of text per backend, by `BACKENDS` and a column per class; changes in points of IoU."""
    lines = [
        _line(score, reference_of(scores, score.network)) | {"pareto": "yes" if best else ""}
        for score, best in zip(scores, front, strict=True)
    ]
    found = pd.DataFrame(lines, columns=[*BACKENDS, *(f"change {name}" for name in CLASSES)], dtype=object)
    # Every way at every scale has its line, measured or not.
    every = pd.MultiIndex.from_product([found["network"].unique(), found["scale"].unique(), WAYS], names=KEYS)
    found = found.set_index(KEYS).reindex(every)
    return found.fillna({"pareto": ""}).fillna(MISSING).reset_index()


def printed(measured: pd.DataFrame, heads: dict[str, str]) -> pd.DataFrame:
    """The columns of a table that have heads, under these, with the names of networks that people read."""
    return measured[list(heads)].assign(network=measured["network"].map(titles())).rename(columns=heads)


def _line(score: Score, plain: Score) -> dict[str, str]:
    change = score.change(plain)
    most = max(change, key=lambda name: abs(change[name]))
    return {
        "network": score.network,
        "scale": f"{score.scale:g}",
        "way": score.way,
        "cpu_ms": f"{score.cpu_ms:.1f}",
        "times_as_fast": f"{plain.cpu_ms / score.cpu_ms:.2f}",
        "miou": f"{score.miou:.2f}",
        "change": signed(score.miou - plain.miou, 2),
        **dict(zip(("low", "high"), (signed(end, 2) for end in score.ends(plain) or ()), strict=False)),
        "most_changed_class": f"{most} {signed(change[most])}" if change[most] else "",
        "largest_logit_change": f"{score.largest:.2g}",
        "changed_percent": f"{score.changed:.3g}",
        **{f"change {name}": signed(change[name], 2) if name in change else DASH for name in CLASSES},
    }
