"""Airlight on degenerate images, learning rate at its end, losses on extreme logits, scores at extreme counts."""

import math
from collections.abc import Iterator
from fractions import Fraction

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
        found = policy.rate(steps - 1, steps)
        expected = 0.01 * math.exp(-0.9 * math.log(steps))
        off = abs(found / expected - 1)
        # 1 - step / steps is rounded at 2^-53 and is 1 / steps: the relative error grows with steps.
        good = isinstance(found, float) and off <= 2.0**-52 * (steps + 4)
        case = f"last of {steps} steps"
        yield Check(
            "training",
            "poly rate",
            case,
            "float64",
            f"{expected:.6g}",
            f"{found:.6g}",
            good,
            None,
            abs(found - expected),
        )


def _losses() -> Iterator[Check]:
    """Cross-entropy of extreme logits, by itself and through hard example mining."""
    import torch

    from foggy_synscapes.training.losses import cross_entropy, hard_examples, pixel_losses

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
        targets = torch.full((1, 2, 2), 3, dtype=torch.uint8)
        losses, labelled, _ = pixel_losses(logits, targets, False)
        for kind, loss in (
            ("cross-entropy", cross_entropy(losses, labelled)),
            ("hard examples", hard_examples(losses, labelled, 0.7, 1 / 16)),
        ):
            (gradient,) = torch.autograd.grad(loss, logits, retain_graph=True)
            found = float(loss.detach())
            off = abs(found - expected)
            good = off <= 2.0**-22 * max(1.0, expected) and bool(torch.isfinite(gradient).all())
            shown = f"{found:.6g}, gradient {'finite' if torch.isfinite(gradient).all() else 'not finite'}"
            yield Check("training", kind, name, "float32", f"{expected:.6g}, gradient finite", shown, good, None, off)
    nothing = torch.full((1, 2, 2), 255, dtype=torch.uint8)
    losses, labelled, _ = pixel_losses(torch.zeros(1, 19, 2, 2), nothing, False)
    for kind, loss in (
        ("cross-entropy", cross_entropy(losses, labelled)),
        ("hard examples", hard_examples(losses, labelled, 0.7, 1 / 16)),
    ):
        yield Check("training", kind, "every pixel ignored", "float32", "0", f"{float(loss):g}", float(loss) == 0)


def _scores() -> Iterator[Check]:
    """IoU of classes without pixels, and of counts that float64 cannot tell apart."""
    empty = np.zeros((3, 4), np.int64)
    empty[0, 0], empty[1, 2] = 5, 4  # class 0 right, class 1 taken for class 2, class 2 not annotated
    found = iou(empty).tolist()
    shown = ", ".join("undefined" if math.isnan(value) else f"{value:g}" for value in found)
    yield Check(
        "scoring",
        "IoU",
        "class 2 is predicted but not annotated",
        "int64",
        "1, 0, undefined",
        shown,
        shown == "1, 0, undefined",
    )
    mean = mean_annotated(found)
    yield Check("scoring", "mean IoU", "over the annotated classes", "float64", "0.5", f"{mean:g}", mean == 0.5)
    nothing = mean_annotated(iou(np.zeros((3, 4), np.int64)).tolist())
    shown = "undefined" if math.isnan(nothing) else f"{nothing:g}"
    yield Check("scoring", "mean IoU", "nothing annotated at all", "float64", "undefined", shown, shown == "undefined")
    big = 2**53
    matrix = np.array([[big + 1, 1, 0], [3, big - 7, 2]], np.int64)
    union = sum(map(int, matrix[0])) + 3
    exact = Fraction(big + 1, union)
    value = float(iou(matrix)[0])
    off = abs(float(Fraction(value) - exact))
    case = "2^53 + 1 right, 1 missed, 3 false: 1 - 4 / (2^53 + 5)"
    yield Check(
        "scoring", "IoU", case, "int64", f"{float(exact):.17g}", f"{value:.17g}", off <= 2.0**-53, off * 2.0**53, off
    )
    total = int(matrix.sum())
    expected = 2 * big
    yield Check("scoring", "pixels counted", "sums above 2^53", "int64", str(expected), str(total), total == expected)
