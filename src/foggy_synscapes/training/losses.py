"""Losses on logits below full resolution."""

import math
from collections.abc import Sequence

import torch
import torch.nn.functional as functional
from torch import Tensor

from foggy_synscapes.networks.network import resize
from foggy_synscapes.training.policy import Policy
from foggy_synscapes.training.ranks import ALONE, Ranks

IGNORE = 255


def grid(labels: Tensor, stride: int, corners: bool) -> Tensor:
    """The pixels that a loss of a stride looks at: integer (B, H, W) -> (B, ceil(H / stride), ceil(W / stride)).

    They are those on which `resize(logits, grid size, corners)` places the values of the enlarged logits, so a stride
    thins out the pixels of the published loss and moves none.
    """
    if stride == 1:
        return labels
    rows, columns = (_positions(size, stride, corners) for size in labels.shape[-2:])
    return labels[:, rows][:, :, columns]


def _positions(size: int, stride: int, corners: bool) -> Tensor:
    count = math.ceil(size / stride)
    steps = torch.arange(count, dtype=torch.float64)
    if corners:
        return (steps * (size - 1) / max(count - 1, 1)).round().long()
    return ((steps + 0.5) * size / count).long()


def pixel_losses(logits: Tensor, targets: Tensor, corners: bool) -> tuple[Tensor, Tensor, Tensor]:
    """Cross-entropy of each pixel, 0 where ignored.

    logits : (B, C, h, w), brought to the targets' size; targets : uint8 (B, H, W), trainIds
    Returns float32 (B * H * W) losses in nats, bool (B * H * W) which pixels are labelled, and logits (B * H * W, C).
    """
    logits = resize(logits.float(), tuple(targets.shape[-2:]), corners)
    flat = logits.permute(0, 2, 3, 1).reshape(-1, logits.shape[1])
    target = targets.reshape(-1).long()
    losses = functional.cross_entropy(flat, target, ignore_index=IGNORE, reduction="none")
    return losses, target != IGNORE, flat


def cross_entropy(losses: Tensor, labelled: Tensor, ranks: Ranks = ALONE) -> Tensor:
    """Mean over the labelled pixels; 0, with a gradient of 0, where there is none.

    Of several processes, each gives what its pixels add to the mean over those of all: the loss is the sum of parts.
    """
    return losses.sum() / ranks.total(labelled.sum()).clamp(min=1)


def hard_examples(losses: Tensor, labelled: Tensor, threshold: float, kept: float, ranks: Ranks = ALONE) -> Tensor:
    """Online hard example mining: mean over the hard pixels.

    A labelled pixel is hard if the probability of its true class is at most `threshold`. If these are fewer than the
    share `kept` of all pixels, ignored ones included, so many of the hardest count, and all as hard as the last. The
    pixels are those of all processes (see `cross_entropy`).
    Source: TorchSeg (ProbOhemCrossEntropy2d), stated there on probabilities; on losses it holds for extreme logits too.
    """
    limit = losses.new_full((1,), -math.log(threshold))
    most = int(kept * (labelled.numel() * ranks.count))
    if most:
        # Ignored pixels must not take places among the hardest: their loss of 0 ties with perfect predictions.
        candidates = losses.detach().masked_fill(~labelled, -1.0)
        # The hardest of all processes' pixels are among the hardest of each.
        hardest = ranks.gathered(candidates.topk(min(most, len(candidates))).values).topk(most).values
        # Without asking how many are labelled, for which a GPU would have to be waited for.
        at_least = ranks.total(labelled.sum()).clamp(1, most)
        limit = torch.minimum(limit, hardest.gather(0, (at_least - 1).view(1)))
    hard = labelled & (losses >= limit)
    return cross_entropy(losses * hard, hard, ranks)


def total(outputs: Sequence[Tensor], targets: Tensor, corners: bool, policy: Policy, ranks: Ranks = ALONE) -> Tensor:
    """Loss of the main output plus the weighted losses of the auxiliary ones; targets uint8 (B, H, W) of `grid`.

    Of several processes, each gives its part of the sum (see `cross_entropy`).
    """
    parts = []
    for logits in outputs:
        losses, labelled, _ = pixel_losses(logits, targets, corners)
        if policy.loss == "ohem":
            parts.append(hard_examples(losses, labelled, policy.ohem_threshold, policy.ohem_kept, ranks))
        else:
            parts.append(cross_entropy(losses, labelled, ranks))
    return parts[0] + policy.auxiliary_weight * sum(parts[1:]) if len(parts) > 1 else parts[0]
