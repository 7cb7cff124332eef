"""Airlight on degenerate images, scores at extreme counts, sums of 8-bit products."""

import json
import math
from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from foggy_synscapes.fog.airlight import Airlight, estimate
from foggy_synscapes.scoring.iou import iou, mean_annotated
from foggy_synscapes.scoring.metrics import summarize
from foggy_synscapes.stability.check import Check


def checks() -> Iterator[Check]:
    """All checks that are neither about the arithmetic of fog nor about training."""
    yield from _airlight()
    yield from _scores()
    yield from _large_counts()
    yield from _eight_bits()


def _airlight() -> Iterator[Check]:
    small = np.random.default_rng(0).integers(0, 256, (20, 30, 3), dtype=np.uint8)
    small[3:18, 5:20] = 220  # the only place where a 15 x 15 square is bright
    levels = {"black": 0, "white": 255, "all tied at 128": 128}
    cases = {name: (np.full((60, 80, 3), level, np.uint8), (level, 0, 0)) for name, level in levels.items()}
    cases["a single pixel"] = np.full((1, 1, 3), 9, np.uint8), (9, 0, 0)
    cases["600 pixels: one candidate"] = small, (220, 10, 12)
    for name, (image, (level, row, column)) in cases.items():
        expected, found = Airlight(level, level, level, row, column), estimate(image)
        asked, got = (f"{light.levels} at {light.row}, {light.column}" for light in (expected, found))
        yield Check("airlight", "levels and pixel", name, "uint8", asked, got, expected == found)


def _scores() -> Iterator[Check]:
    """IoU of classes without pixels, and of counts that float64 cannot tell apart."""
    empty = np.zeros((3, 4), np.int64)
    empty[0, 0], empty[1, 2] = 5, 4  # class 0 right, class 1 taken for class 2, class 2 not annotated
    mean, nothing = mean_annotated(iou(empty).tolist()), mean_annotated(iou(np.zeros((3, 4), np.int64)).tolist())
    for quantity, case, form, expected, found in (
        ("IoU", "class 2 is predicted but not annotated", "int64", "1, 0, undefined", iou(empty).tolist()),
        ("mean IoU", "over the annotated classes", "float64", "0.5", [mean]),
        ("mean IoU", "nothing annotated at all", "float64", "undefined", [nothing]),
    ):
        shown = ", ".join("undefined" if math.isnan(value) else f"{value:g}" for value in found)
        yield Check("scoring", quantity, case, form, expected, shown, shown == expected)
    big = 2**53
    matrix = np.array([[big + 1, 1, 0], [3, big - 7, 2]], np.int64)
    exact = Fraction(big + 1, sum(map(int, matrix[0])) + 3)
    value = float(iou(matrix)[0])
    off = abs(float(Fraction(value) - exact))
    case, texts = "2^53 + 1 right, 1 missed, 3 false: 1 - 4 / (2^53 + 5)", (f"{float(exact):.17g}", f"{value:.17g}")
    yield Check("scoring", "IoU", case, "int64", *texts, off <= 2.0**-53, off * 2.0**53, off)
    total = int(matrix.sum())
    yield Check("scoring", "pixels counted", "sums above 2^53", "int64", str(2 * big), str(total), total == 2 * big)


def _large_counts() -> Iterator[Check]:
    """A test set of 2^53 pixels: its scores, and its counts in the file of metrics."""
    counts = np.random.default_rng(0).integers(0, 1000, (19, 20))
    few, many = (summarize(matrix, 1) for matrix in (counts, counts * 2**35))
    off = max(abs(one["iou"] - other["iou"]) for one, other in zip(few["classes"], many["classes"], strict=True))
    off = max(off, *(abs(few[key] - many[key]) for key in ("pixel_accuracy", "frequency_weighted_iou")))
    pixels = int(counts.sum()) * 2**35
    case = f"{pixels / 2**53:.1f} times 2^53 pixels, against 2^35 times fewer"
    yield Check("scoring", "IoU and accuracy", case, "int64", "off by 0", f"off by {off:g}", off == 0, None, off)
    counts[0, 0] = 2**53 + 1
    read = json.loads(json.dumps(summarize(counts, 1)))["confusion"][0][0]
    yield Check(
        "scoring", "confusion", "2^53 + 1 in metrics.json", "int64", str(2**53 + 1), str(read), read == 2**53 + 1
    )


def _eight_bits() -> Iterator[Check]:
    """Largest sums of products of an unsigned and a signed byte, as int8 networks add them up."""
    for case, products, bits in (
        ("sum over 3 x 3 pixels of 2048 channels", 2048 * 9, 32),
        ("sum of two products on processors without VNNI", 2, 16),
    ):
        largest, limit = 255 * 127 * products, 2 ** (bits - 1) - 1
        texts = f"at most {limit}", f"{largest}{'' if largest <= limit else ': saturates'}"
        yield Check("networks", "int8", case, f"int{bits}", *texts, largest <= limit)
