"""What a snapshot is selected by."""

import math
from collections.abc import Iterator

import numpy as np
import torch
from torch import Tensor

from foggy_synscapes.networks.network import Network
from foggy_synscapes.networks.weights import Preprocessing
from foggy_synscapes.training.forward import Arithmetic, NotFiniteError, forward
from foggy_synscapes.training.loader import Batch, Samples, collate
from foggy_synscapes.training.losses import pixel_losses
from foggy_synscapes.training.policy import Policy


def validate(
    network: Network, preprocessing: Preprocessing, policy: Policy, arithmetic: Arithmetic, samples: Samples
) -> tuple[float, float]:
    """Loss, and mean IoU in percent, of the main output on whole images; leaves the network in evaluation mode.

    Both count the labelled pixels that the policy's `loss_stride` looks at, all alike, whatever image they are of. The
    loss is plain cross-entropy also where training mines hard examples: their choice differs from snapshot to snapshot,
    so it cannot compare them. The mean is over the classes that are annotated.
    """
    network.eval()
    classes = network.config.classes
    total, confusion = 0.0, torch.zeros(classes, classes, dtype=torch.int64)
    for batch in _groups(samples, policy.batch):
        with torch.inference_mode():
            outputs, targets = forward(
                network, preprocessing, arithmetic, policy.loss_stride, batch.images, batch.labels
            )
            losses, labelled, logits = pixel_losses(outputs[0], targets, network.corners)
            loss = float(losses.sum(dtype=torch.float64))
            pairs = targets.reshape(-1)[labelled].long() * classes + logits[labelled].argmax(dim=1)
            confusion += torch.bincount(pairs, minlength=classes**2).view(classes, classes).cpu()
        if not math.isfinite(loss):
            names = ", ".join(samples.name(index) for index in batch.indices)
            raise NotFiniteError(f"validation loss is {loss}, on {names}. Is the learning rate too high?")
        total += loss
    count = int(confusion.sum())
    if count == 0:
        raise ValueError("validation: no labelled pixel in the whole list")
    return total / count, _mean_iou(confusion)


def _groups(samples: Samples, size: int) -> Iterator[Batch]:
    """Samples in their order, neighbours of one size together, at most so many."""
    images: list[np.ndarray] = []
    labels: list[np.ndarray] = []
    indices: list[int] = []
    for index in range(samples.count):
        image, label = samples.load(index)
        if indices and (len(indices) == size or image.shape != images[0].shape):
            yield collate(images, labels, indices)
            images, labels, indices = [], [], []
        images.append(image)
        labels.append(label)
        indices.append(index)
    yield collate(images, labels, indices)


def _mean_iou(confusion: Tensor) -> float:
    true_positives, annotated, predicted = confusion.diagonal(), confusion.sum(1), confusion.sum(0)
    shares = true_positives.double() / (annotated + predicted - true_positives).clamp(min=1)
    return float(100 * shares[annotated > 0].mean())
