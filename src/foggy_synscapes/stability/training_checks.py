"""Training at its extremes: learning rate, losses and their arithmetic, batch norm, sums over a long training."""

import math
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from functools import partial

import numpy as np
import torch
import torch.nn.functional as functional
from torch import Tensor

from foggy_synscapes.networks import NetworkConfig
from foggy_synscapes.networks.network import build
from foggy_synscapes.networks.weights import check_fit
from foggy_synscapes.stability.check import Check
from foggy_synscapes.training.losses import cross_entropy, hard_examples, pixel_losses
from foggy_synscapes.training.policy import Policy

AREA, CLASSES, IGNORE, EPSILON = "training", 19, 255, 1e-5
LOSSES: dict[str, Callable[[Tensor, Tensor], Tensor]] = {
    "cross-entropy": cross_entropy,
    "hard examples": partial(hard_examples, threshold=0.7, kept=1 / 16),
}
STEPS, PARTED = 300, 0.01
"""Steps of the small training, and the relative difference of two losses that counts as parted."""
ARITHMETIC = {
    "float32": (torch.float32, None),
    "autocast to bfloat16": (torch.float32, torch.bfloat16),
    "autocast to float16": (torch.float32, torch.float16),
    "bfloat16": (torch.bfloat16, None),
    "float16": (torch.float16, None),
}
"""Type of the weights, and that to which a network's outputs are cast; the first one is what the others part from."""


def checks() -> Iterator[Check]:
    """All checks of training."""
    yield from _learning_rate()
    yield from _extreme_logits()
    yield from _no_numbers()
    yield from _mining()
    yield from _formats()
    yield from _parting()
    yield from _batch_norm()
    yield from _long_sums()


def _learning_rate() -> Iterator[Check]:
    """The poly schedule at its last step: positive, real, and what exact arithmetic gives."""
    for steps in (1, 6125, 10**9):
        policy = Policy(learning_rate=0.01, schedule="poly", power=0.9, batch=1, crop=(1, 1), scale=(1, 1))
        found, expected = policy.rate(steps - 1, steps), 0.01 * math.exp(-0.9 * math.log(steps))
        # 1 - step / steps is rounded at 2^-53 and is 1 / steps: the relative error grows with steps.
        good = isinstance(found, float) and abs(found / expected - 1) <= 2.0**-52 * (steps + 4)
        case, texts = f"last of {steps} steps", (f"{expected:.6g}", f"{found:.6g}")
        yield Check(AREA, "poly rate", case, "float64", *texts, good, None, abs(found - expected))


def _losses(logits: Tensor, target: int) -> Iterator[tuple[str, float, bool]]:
    """Each loss of logits (1, C, 2, 2) on pixels of one class: its value, and whether its gradient is finite."""
    logits.requires_grad_(True)
    losses, labelled, _ = pixel_losses(logits, torch.full((1, 2, 2), target, dtype=torch.uint8), False)
    for kind, reduce in LOSSES.items():
        loss = reduce(losses, labelled)
        (gradient,) = torch.autograd.grad(loss, logits, retain_graph=True)
        yield kind, float(loss.detach()), bool(torch.isfinite(gradient).all())


def _extreme_logits() -> Iterator[Check]:
    """Losses of extreme logits, by themselves and through hard example mining."""
    cases = {
        "true class at +1e4": (1e4, 0.0),
        "true class at -1e4": (-1e4, 1e4 + math.log(18)),
        "true class at -1e30": (-1e30, 1e30),
        "all 19 logits equal": (0.0, math.log(19)),
    }
    for name, (logit, expected) in cases.items():
        logits = torch.zeros(1, CLASSES, 2, 2)
        logits[:, 3] = logit
        for kind, found, finite in _losses(logits, 3):
            off = abs(found - expected)
            good = off <= 2.0**-22 * max(1.0, expected) and finite
            texts = f"{expected:.6g}, gradient finite", f"{found:.6g}, gradient {'finite' if finite else 'not finite'}"
            yield Check(AREA, kind, name, "float32", *texts, good, None, off)
    for kind, loss, _ in _losses(torch.zeros(1, CLASSES, 2, 2), IGNORE):
        yield Check(AREA, kind, "every pixel ignored", "float32", "0", f"{loss:g}", loss == 0)


def _no_numbers() -> Iterator[Check]:
    """A logit that is no number has to show in the loss, where training and validation stop at it."""
    for name, place, value, expected in (
        ("one logit is NaN", 5, math.nan, "nan"),
        ("true class at minus infinity", 3, -math.inf, "inf"),
        ("another class at minus infinity", 5, -math.inf, f"{math.log(18):.6g}"),
    ):
        logits = torch.zeros(1, CLASSES, 2, 2)
        logits[0, place, 0, 0] = value
        if math.isfinite(float(expected)):
            logits[:, place] = value
        for kind, loss, _ in _losses(logits, 3):
            yield Check(AREA, kind, name, "float32", expected, f"{loss:.6g}", f"{loss:.6g}" == expected)


def _mining() -> Iterator[Check]:
    """Hard example mining that keeps every pixel is the cross-entropy, and that keeps none is 0."""
    generator = torch.Generator().manual_seed(0)
    logits = torch.randn(1, CLASSES, 16, 16, generator=generator)
    losses, labelled, _ = pixel_losses(logits, _targets(generator, 1), False)
    for case, threshold, kept, expected in (
        ("every pixel kept by its share", 1e-9, 1.0, float(cross_entropy(losses, labelled))),
        ("every pixel kept by its probability", 1.0, 0.0, float(cross_entropy(losses, labelled))),
        ("no pixel kept", 1e-9, 0.0, 0.0),
    ):
        found = float(hard_examples(losses, labelled, threshold, kept))
        off = abs(found - expected)
        texts = f"{expected:.6g}", f"{found:.6g}"
        yield Check(AREA, "hard examples", case, "float32", *texts, off <= 2.0**-22 * max(1.0, expected), None, off)


def _targets(generator: torch.Generator, images: int) -> Tensor:
    return torch.randint(CLASSES, (images, 16, 16), dtype=torch.uint8, generator=generator)


def _formats() -> Iterator[Check]:
    """Losses of logits that a network gave in a short format; they are computed in float32."""
    generator = torch.Generator().manual_seed(0)
    logits, targets = 10 * torch.randn(4, CLASSES, 16, 16, generator=generator).double(), _targets(generator, 4)
    flat = logits.permute(0, 2, 3, 1).reshape(-1, CLASSES)
    exact = functional.cross_entropy(flat, targets.reshape(-1).long(), reduction="none")
    labelled = torch.ones_like(exact, dtype=torch.bool)
    for form, dtype in (("float32", torch.float32), ("bfloat16", torch.bfloat16), ("float16", torch.float16)):
        # Each logit is off by half an ulp at most, and the loss is the difference of two such.
        bound = float(logits.abs().max()) * torch.finfo(dtype).eps + 1e-5
        losses = pixel_losses(logits.to(dtype), targets, False)[0]
        for kind, reduce in LOSSES.items():
            off = abs(float(reduce(losses, labelled)) - float(reduce(exact, labelled)))
            case = f"logits of a deviation of 10 held in {form}: absolute error"
            yield Check(AREA, kind, case, form, f"at most {bound:.1e}", f"{off:.1e}", off <= bound, None, off)


def _parting() -> Iterator[Check]:
    """After how many steps a small training in a short format is another one than in float32."""
    for kind, reduce in LOSSES.items():
        curves = {name: _small_training(reduce, *types) for name, types in ARITHMETIC.items()}
        plain = curves.pop("float32")
        for name, curve in curves.items():
            apart = np.flatnonzero(~(np.abs(curve - plain) <= PARTED * plain))
            found = f"from step {apart[0] + 1} on" if apart.size else f"not within {STEPS} steps"
            case = f"training parts from float32 by {100 * PARTED:g} %"
            yield Check(AREA, kind, case, name, "never", found, not apart.size)


def _small_training(
    reduce: Callable[[Tensor, Tensor], Tensor], kind: torch.dtype, cast: torch.dtype | None
) -> np.ndarray:
    """Losses of a linear network that learns what another one sees: SGD with momentum, on the same pixels each time."""
    generator = torch.Generator().manual_seed(0)
    features = torch.randn(2, 16, 16, 16, generator=generator)
    targets = (features @ torch.randn(16, CLASSES, generator=generator)).argmax(dim=3).to(torch.uint8)
    features = features.to(kind)
    weight = (0.1 * torch.randn(CLASSES, 16, generator=generator)).to(kind).requires_grad_(True)
    optimiser = torch.optim.SGD([weight], lr=0.05, momentum=0.9)
    losses = []
    for _ in range(STEPS):
        with nullcontext() if cast is None else torch.autocast("cpu", cast):
            logits = functional.linear(features, weight).permute(0, 3, 1, 2)
        loss = reduce(*pixel_losses(logits, targets, False)[:2])
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        losses.append(float(loss.detach()))
    return np.array(losses)


def _batch_norm() -> Iterator[Check]:
    """Statistics of a single value, of equal values, and imported ones that cannot be."""
    scale, shift = torch.full((4,), 2.0), torch.full((4,), 0.5)
    try:
        functional.batch_norm(torch.ones(1, 4, 1, 1), None, None, scale, shift, training=True)
        found = "computed"
    except ValueError:
        found = "refused"
    yield Check(
        AREA, "batch norm", "training on one value per channel", "float32", "refused", found, found == "refused"
    )
    # PyTorch multiplies before it subtracts: what cancels is as large as 7 * 2 / sqrt(epsilon).
    equal = functional.batch_norm(torch.full((2, 4, 3, 3), 7.0), None, None, scale, shift, training=True)
    off, bound = float((equal - 0.5).abs().max()), 7 * 2 / math.sqrt(EPSILON) * 2.0**-23
    texts = f"0.5, off by at most {bound:.1e}", f"off by {off:.1e}"
    yield Check(
        AREA, "batch norm", "training on equal values of 7: its shift", "float32", *texts, off <= bound, None, off
    )
    network = build(NetworkConfig("bisenet", "resnet18", 8, 4))
    for variance, expected in (
        (0.0, "taken"),
        (-5e-6, "taken"),
        (-1e-5, "refused"),
        (-1.0, "refused"),
        (math.nan, "refused"),
    ):
        tensors = {name: tensor.clone() for name, tensor in network.state_dict().items()}
        tensors[next(name for name in tensors if name.endswith("running_var"))][0] = variance
        try:
            check_fit(network, tensors)
            found = "taken"
        except ValueError:
            found = "refused"
        yield Check(
            AREA, "batch norm", f"imported variance of {variance:g}", "float32", expected, found, found == expected
        )


def _long_sums() -> Iterator[Check]:
    """The mean of the losses of a long training: summed step by step in float64, as the training loop does."""
    losses = np.random.default_rng(0).gamma(2.0, 1.0, 10**6).astype(np.float32)
    exact = math.fsum(losses.tolist())
    for form, bound in (("float64", 1e-10), ("float32", 1e-4)):
        total = float(np.cumsum(losses, dtype=form)[-1])
        off = abs(total / exact - 1)
        case = "sum over 1e6 steps: relative error"
        yield Check(AREA, "mean loss", case, form, f"at most {bound:.0e}", f"{off:.1e}", off <= bound, None, off)
