"""Airlight on degenerate images, learning rate at its end, losses on extreme logits, scores at extreme counts."""

import math
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import partial

import numpy as np

from foggy_synscapes.fog.airlight import Airlight, estimate
from foggy_synscapes.scoring.iou import iou, mean_annotated
from foggy_synscapes.stability.check import Check


def checks() -> Iterator[Check]:
    """All checks that are not about number formats of fog."""
    yield from _airlight()
    yield from _learning_rate()
    yield from _losses()
    yield from _scores()


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


def _learning_rate() -> Iterator[Check]:
    """The poly schedule at its last step: positive, real, and what exact arithmetic gives."""
    from foggy_synscapes.training.policy import Policy

    for steps in (1, 6125, 10**9):
        policy = Policy(learning_rate=0.01, schedule="poly", power=0.9, batch=1, crop=(1, 1), scale=(1, 1))
        found, expected = policy.rate(steps - 1, steps), 0.01 * math.exp(-0.9 * math.log(steps))
        # 1 - step / steps is rounded at 2^-53 and is 1 / steps: the relative error grows with steps.
        good = isinstance(found, float) and abs(found / expected - 1) <= 2.0**-52 * (steps + 4)
        case, texts = f"last of {steps} steps", (f"{expected:.6g}", f"{found:.6g}")
        yield Check("training", "poly rate", case, "float64", *texts, good, None, abs(found - expected))


def _losses() -> Iterator[Check]:
    """Cross-entropy of extreme logits, by itself and through hard example mining."""
    import torch

    from foggy_synscapes.training.losses import cross_entropy, hard_examples, pixel_losses

    kinds: dict[str, Callable] = {
        "cross-entropy": cross_entropy,
        "hard examples": partial(hard_examples, threshold=0.7, kept=1 / 16),
    }
    cases = {
        "true class at +1e4": (1e4, 0.0),
        "true class at -1e4": (-1e4, 1e4 + math.log(18)),
        "true class at -1e30": (-1e30, 1e30),
        "all 19 logits equal": (0.0, math.log(19)),
    }
    for name, (logit, expected) in cases.items():
        logits = torch.zeros(1, 19, 2, 2)
        logits[:, 3] = logit
        logits.requires_grad_(True)
        losses, labelled, _ = pixel_losses(logits, torch.full((1, 2, 2), 3, dtype=torch.uint8), False)
        for kind, reduce in kinds.items():
            loss = reduce(losses, labelled)
            (gradient,) = torch.autograd.grad(loss, logits, retain_graph=True)
            found, finite = float(loss.detach()), bool(torch.isfinite(gradient).all())
            off = abs(found - expected)
            good = off <= 2.0**-22 * max(1.0, expected) and finite
            texts = f"{expected:.6g}, gradient finite", f"{found:.6g}, gradient {'finite' if finite else 'not finite'}"
            yield Check("training", kind, name, "float32", *texts, good, None, off)
    nothing = torch.full((1, 2, 2), 255, dtype=torch.uint8)
    losses, labelled, _ = pixel_losses(torch.zeros(1, 19, 2, 2), nothing, False)
    for kind, reduce in kinds.items():
        nought = float(reduce(losses, labelled))
        yield Check("training", kind, "every pixel ignored", "float32", "0", f"{nought:g}", nought == 0)


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
