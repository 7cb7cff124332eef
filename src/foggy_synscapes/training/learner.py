"""A network in training: its passes, its steps, and the validations by which a snapshot is selected."""

import math
from collections.abc import Callable, Iterable
from contextlib import nullcontext
from dataclasses import dataclass

import torch
import torch.nn.functional as functional
from torch import Tensor, nn
from torch.nn.parallel import DistributedDataParallel

from foggy_synscapes.networks.network import Network, padded
from foggy_synscapes.networks.weights import Model
from foggy_synscapes.training import losses
from foggy_synscapes.training.loader import Batch
from foggy_synscapes.training.policy import Policy
from foggy_synscapes.training.ranks import ALONE, Ranks, share


class NotFiniteError(ValueError):
    """A loss is infinite or no number; the message names the samples."""


@dataclass(frozen=True)
class Arithmetic:
    """Where and on which numbers a network computes.

    device : "cpu" or "cuda"
    precision : "float32", or by autocast, with weights in float32, "bfloat16" or "float16", where the loss is scaled
    memory_format : "channels_last", in which convolutions on processors are faster, or "contiguous"
    compile : train on the network compiled by `torch.compile`; validation stays as it is, for images of any size
    """

    device: str = "cpu"
    precision: str = "float32"
    memory_format: str = "channels_last"
    compile: bool = False

    def layout(self) -> torch.memory_format:
        """PyTorch's name for the memory format."""
        return torch.channels_last if self.memory_format == "channels_last" else torch.contiguous_format


class Outputs(nn.Module):
    """A network whose call gives the outputs that losses are made of, for wrappers that know calls only."""

    def __init__(self, network: Network) -> None:
        super().__init__()
        self.network = network

    def forward(self, images: Tensor) -> list[Tensor]:
        return self.network.outputs(images)


class Learner:
    """A network on its device, with its optimiser, as a policy says. Frozen batch norm stays as it is."""

    def __init__(self, model: Model, policy: Policy, arithmetic: Arithmetic, ranks: Ranks = ALONE) -> None:
        self.network, self.preprocessing, self.policy, self.ranks = model.network, model.preprocessing, policy, ranks
        self.arithmetic = arithmetic
        self.network.to(device=arithmetic.device, memory_format=arithmetic.layout())  # type: ignore[call-overload]
        set_training(self.network, policy)
        half = arithmetic.precision == "float16"
        # Fused, it skips the steps in which scaled gradients overflowed without asking the GPU.
        fused = True if half and arithmetic.device == "cuda" else None
        groups = parameter_groups(self.network, policy)
        self.optimiser = torch.optim.SGD(groups, lr=policy.learning_rate, momentum=policy.momentum, fused=fused)
        self.scaler = torch.amp.GradScaler(arithmetic.device, enabled=half)
        self._parallel: DistributedDataParallel | None = None
        self._outputs: Callable[[Tensor], list[Tensor]] = self.network.outputs

    def wrap(self) -> None:
        """Share the network with the other processes, and compile it, where that is asked for.

        Sharing replaces layers, but not their parameters, which the optimiser has.
        """
        if self.ranks.count > 1:
            share(self.network, self.ranks)
            # Batch norm's statistics need no broadcast: every process computes the same ones.
            self._parallel = DistributedDataParallel(Outputs(self.network), forward_sync_buffers=False)
            self._outputs = self._parallel
        if self.arithmetic.compile:
            # PyTorch's compiler has a setting of its own for repeatable algorithms, which follows this call alone.
            torch.use_deterministic_algorithms(torch.are_deterministic_algorithms_enabled())
            self._outputs = torch.compile(self._parallel or Outputs(self.network))

    def forward(
        self, images: Tensor, labels: Tensor, outputs: Callable[[Tensor], list[Tensor]] | None = None
    ) -> tuple[list[Tensor], Tensor]:
        """The network's outputs (or those of a wrapper of it), and the targets that the policy's loss looks at.

        images : uint8 (B, 3, H, W); labels : uint8 (B, H, W). Both are padded to the network's stride, labels with
        ignored pixels. The targets are uint8 (B, h, w), see `losses.grid`.
        """
        device, precision = self.arithmetic.device, self.arithmetic.precision
        inputs = padded(self.preprocessing.apply(images.to(device, non_blocking=True)))
        compute = self.network.outputs if outputs is None else outputs
        with torch.autocast(device, getattr(torch, precision), enabled=precision != "float32"):
            found = compute(inputs.contiguous(memory_format=self.arithmetic.layout()))
        below, right = inputs.shape[-2] - labels.shape[-2], inputs.shape[-1] - labels.shape[-1]
        if below or right:  # else pinned memory stays pinned
            labels = functional.pad(labels, (0, right, 0, below), value=losses.IGNORE)
        targets = losses.grid(labels, self.policy.loss_stride, self.network.corners)
        return found, targets.to(device, non_blocking=True)

    def step(self, batch: Batch) -> float:
        """One optimiser step; returns the loss, the mean over the passes into which the batch is split."""
        self.optimiser.zero_grad(set_to_none=True)
        passes, count = self.policy.accumulate, self.ranks.count
        value = torch.zeros((), dtype=torch.float64, device=self.arithmetic.device)
        parts = zip(batch.images.chunk(passes), batch.labels.chunk(passes), strict=True)
        for number, (images, labels) in enumerate(parts, start=1):
            # Gradients stay in their process but for the last pass.
            with self._parallel.no_sync() if self._parallel and number < passes else nullcontext():
                outputs, targets = self.forward(images, labels, self._outputs)
                loss = losses.total(outputs, targets, self.network.corners, self.policy, self.ranks) / passes
                # Gradients are averaged over the processes, but the loss is the sum of their parts.
                self.scaler.scale(loss * count if count > 1 else loss).backward()
            value += self.ranks.total(loss.detach())
        found = float(value)  # the only time that a step waits for the device
        if math.isfinite(found):
            self.scaler.step(self.optimiser)
            self.scaler.update()
        return found

    def validate(self, batches: Iterable[Batch], name: Callable[[int], str]) -> tuple[float, float]:
        """Loss, and mean IoU in percent, of the main output on whole images.

        Both count the labelled pixels that the policy's `loss_stride` looks at, all alike, whatever image they are of.
        The loss is plain cross-entropy also where training mines hard examples: their choice differs from snapshot to
        snapshot, so it cannot compare them. The mean is over the classes that are annotated. name : of a sample

        Raises NotFiniteError, and ValueError where no pixel is labelled.
        """
        self.network.eval()
        classes = self.network.config.classes
        total, confusion = 0.0, torch.zeros(classes, classes, dtype=torch.int64)
        for batch in batches:
            with torch.inference_mode():
                outputs, targets = self.forward(batch.images, batch.labels)
                each, labelled, logits = losses.pixel_losses(outputs[0], targets, self.network.corners)
                loss = float(each.sum(dtype=torch.float64))
                pairs = targets.reshape(-1)[labelled].long() * classes + logits[labelled].argmax(dim=1)
                confusion += torch.bincount(pairs, minlength=classes**2).view(classes, classes).cpu()
            if not math.isfinite(loss):
                names = ", ".join(map(name, batch.indices))
                raise NotFiniteError(f"validation loss is {loss}, on {names}. Is the learning rate too high?")
            total += loss
        set_training(self.network, self.policy)
        count = int(confusion.sum())
        if count == 0:
            raise ValueError("validation: no labelled pixel in the whole list")
        true_positives, annotated, predicted = confusion.diagonal(), confusion.sum(1), confusion.sum(0)
        shares = true_positives.double() / (annotated + predicted - true_positives).clamp(min=1)
        return total / count, float(100 * shares[annotated > 0].mean())


def parameter_groups(network: Network, policy: Policy) -> list[dict]:
    """Groups for an optimiser, each with `factor` of the learning rate and `weight_decay`; without what is frozen."""
    norms = {id(p) for m in network.modules() if isinstance(m, nn.BatchNorm2d) for p in m.parameters()}
    groups: dict[tuple[float, float], list[nn.Parameter]] = {}
    for name, parameter in network.named_parameters():
        if parameter.requires_grad:
            factor = policy.backbone_rate if name.startswith("backbone.") else policy.new_layer_rate
            plain = id(parameter) in norms or name.endswith(".bias")
            decay = policy.norm_weight_decay if plain else policy.weight_decay
            groups.setdefault((factor, decay), []).append(parameter)
    return [{"params": p, "factor": factor, "weight_decay": decay} for (factor, decay), p in groups.items()]


def set_training(network: Network, policy: Policy) -> None:
    """Training mode; batch norm stays in evaluation mode, and its parameters get no gradient, where it is frozen."""
    network.train()
    for module in network.modules() if policy.freeze_batch_norm else ():
        if isinstance(module, nn.BatchNorm2d):
            module.eval().requires_grad_(False)
