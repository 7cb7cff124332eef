"""What shortcuts of fog cost in mean IoU: fixed models on the same frames, in fog that is made in each way."""

import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import torch

from foggy_synscapes.fog.airlight import estimate
from foggy_synscapes.io.images import encode_png, read_rgb
from foggy_synscapes.io.progress import progress
from foggy_synscapes.networks import titles
from foggy_synscapes.networks.weights import Model
from foggy_synscapes.scoring.bootstrap import in_words, interval, mean_iou, rounded_up
from foggy_synscapes.scoring.tally import image_matrix
from foggy_synscapes.tables.table import MISSING, signed
from foggy_synscapes.tradeoff.fog import OURS, Frame
from foggy_synscapes.tradeoff.fog_variants import variants

QUALITIES = (95, 85, 75)
REFERENCE = "PNG of the default"
THREADS = 1
COLUMNS = {
    "network": "Network", "shortcut": "Shortcut", "about": "What it is", "kilobytes": "kB per image", "miou": "mIoU",
    "change": "Change", "low": "From", "high": "To", "conclusion": "Conclusion",
}  # fmt: skip
"""Columns of the CSV file, and their heads where people read them."""

Light = Sequence[int]
Make = Callable[[Frame, Light, Light, Sequence[float]], tuple[np.ndarray, float | None]]
"""From a frame, its airlight and that of the frame before to images uint8 (B, H, W, 3), and bytes each where stored."""


@dataclass(frozen=True)
class Shortcut:
    """A way of making foggy images."""

    name: str
    about: str
    make: Make


@dataclass(frozen=True)
class Score:
    """A network's mean IoU in percent on one shortcut's images, its change, and the ends of its interval, in points."""

    network: str
    shortcut: Shortcut
    size: float | None
    miou: float
    change: float
    ends: tuple[float, float] | None


def shortcuts() -> list[Shortcut]:
    """The reference first: the default way, stored without loss."""
    ways = {variant.name: variant for variant in variants()}
    default = ways.pop(OURS).way

    def other(name: str) -> Shortcut:
        way = ways[name].way
        return Shortcut(name, ways[name].about, lambda frame, light, _, betas: (way(*frame, light, betas), None))

    def stored(frame: Frame, light: Light, _: Light, betas: Sequence[float]) -> tuple[np.ndarray, float]:
        images = default(*frame, light, betas)
        return images, float(np.mean([len(encode_png(image)) for image in images]))

    def neighbour(frame: Frame, _: Light, before: Light, betas: Sequence[float]) -> tuple[np.ndarray, None]:
        return default(*frame, before, betas), None

    def grey(frame: Frame, light: Light, _: Light, betas: Sequence[float]) -> tuple[np.ndarray, None]:
        return default(*frame, (round(sum(map(int, light)) / 3),) * 3, betas), None

    def lossy(quality: int) -> Shortcut:
        def make(frame: Frame, light: Light, _: Light, betas: Sequence[float]) -> tuple[np.ndarray, float]:
            read, sizes = zip(*(as_jpeg(image, quality) for image in default(*frame, light, betas)), strict=True)
            return np.stack(read), float(np.mean(sizes))

        return Shortcut(f"JPEG {quality}", f"stored with quality {quality}, colours halved", make)

    return [
        Shortcut(REFERENCE, "the reference", stored),
        *(other(name) for name in ways),
        Shortcut("airlight of another frame", "that of the frame before", neighbour),
        Shortcut("grey airlight", "the mean of its channels", grey),
        *(lossy(quality) for quality in QUALITIES),
    ]


def as_jpeg(image: np.ndarray, quality: int) -> tuple[np.ndarray, int]:
    """An image, uint8 (H, W, 3), as it is read back from a JPEG, and the bytes of that."""
    import OpenImageIO as oiio

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "image.jpg"
        spec = oiio.ImageSpec(image.shape[1], image.shape[0], 3, "uint8")
        spec.attribute("Compression", f"jpeg:{quality}")
        spec.attribute("jpeg:subsampling", "4:2:0")
        buffer = oiio.ImageBuf(spec)
        buffer.set_pixels(oiio.ROI(), np.ascontiguousarray(image))
        if not buffer.write(str(path)):
            raise OSError(f"JPEG of quality {quality}: {buffer.geterror()}")
        return read_rgb(path, "JPEG"), path.stat().st_size


def measure(
    models: Mapping[str, Model],
    frames: Sequence[Frame],
    labels: Sequence[np.ndarray],
    betas: Sequence[float],
    seconds: float,
) -> tuple[list[Score], int]:
    """Score every model on every shortcut's images; also how many frames that was done with in the time.

    labels : labelIds of each frame, uint8 (H, W); seconds : after which no further frame is begun, of two at least

    A frame at all betas counts as one image of the bootstrap: its pictures are not independent.
    """
    torch.set_num_threads(THREADS)
    ways, started = shortcuts(), time.monotonic()
    lights = [estimate(frame[0]).levels for frame in frames]
    counts: dict[tuple[str, str], list[np.ndarray]] = {(name, way.name): [] for name in models for way in ways}
    sizes: dict[str, list[float]] = {way.name: [] for way in ways}
    done = 0
    for number, (frame, truth) in enumerate(progress(list(zip(frames, labels, strict=True)), "tradeoff accuracy")):
        if done >= 2 and time.monotonic() - started > seconds:
            break
        reference = None
        for way in ways:
            images, size = way.make(frame, lights[number], lights[number - 1], betas)
            if size is not None:
                sizes[way.name].append(size)
            reference = images if reference is None else reference
            same = way.name != REFERENCE and np.array_equal(images, reference)
            for name, model in models.items():
                # A frame at all betas is one image.
                found = (
                    counts[name, REFERENCE][-1] if same else sum(image_matrix(truth, model.predict(x)) for x in images)
                )
                counts[name, way.name].append(np.asarray(found))
        done += 1
    scores = []
    for (name, shortcut), matrices in counts.items():
        plain, own = np.stack(counts[name, REFERENCE]), np.stack(matrices)
        miou, before = float(mean_iou(own.sum(axis=0))), float(mean_iou(plain.sum(axis=0)))
        size = float(np.mean(sizes[shortcut])) if sizes[shortcut] else None
        way = next(way for way in ways if way.name == shortcut)
        scores.append(Score(name, way, size, miou, miou - before, interval(plain, own)))
    return scores, done


def table(scores: Sequence[Score]) -> pd.DataFrame:
    """One line of text per network and shortcut, by `COLUMNS`."""
    lines = [
        (
            one.network, one.shortcut.name, one.shortcut.about,
            MISSING if one.size is None else f"{one.size / 1000:.1f}", f"{one.miou:.2f}", signed(one.change, 2),
            *((MISSING, MISSING) if one.ends is None else (signed(end, 2) for end in one.ends)),
            "" if one.shortcut.name == REFERENCE else in_words(one.change, one.ends),
        )
        for one in scores
    ]  # fmt: skip
    return pd.DataFrame(lines, columns=list(COLUMNS))


def paragraph(scores: Sequence[Score]) -> str:
    """For each network which shortcuts change its mean IoU beyond their interval, and which do not."""
    parts = []
    for network in dict.fromkeys(score.network for score in scores):
        text, within = [f"**{titles()[network]}.**"], {}
        for one in sorted(scores, key=lambda one: one.change):
            if one.network != network or one.shortcut.name == REFERENCE:
                continue
            if one.ends is None or not any(one.ends) or one.ends[0] <= 0 <= one.ends[1]:
                within[one.shortcut.name] = 0.0 if one.ends is None else max(-one.ends[0], one.ends[1], 0.0)
            else:
                text.append(f"{one.shortcut.name} {in_words(one.change, one.ends)}.")
        if all(one.ends is None for one in scores):
            text.append("Of one image there is no interval: nothing can be said.")
        else:
            same = [name for name, most in within.items() if most == 0]
            text += [f"Not one pixel changes, or the change cancels: {', '.join(same)}."] if same else []
            open_ = [name for name in within if name not in same]
            most = max(within.values(), default=0.0)
            text += [f"No difference found above {rounded_up(most):.2f} points: {', '.join(open_)}."] if open_ else []
        parts.append(" ".join(text))
    return "\n\n".join(parts)
