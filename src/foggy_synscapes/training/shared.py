"""Layers that see the whole batch while each process holds a slice of it."""

import torch
import torch.distributed as distributed
from torch import Tensor, nn

from foggy_synscapes.training.ranks import Ranks


def share(network: nn.Module, ranks: Ranks) -> None:
    """Replace the layers that depend on the whole batch by ones that see it; parameters and their names stay."""
    for name, layer in network.named_children():
        if isinstance(layer, nn.BatchNorm2d) and layer.training:
            # PyTorch's own runs on GPUs only.
            on_gpu = layer.weight.is_cuda
            synced = nn.SyncBatchNorm.convert_sync_batchnorm(layer) if on_gpu else SharedBatchNorm.of(layer, ranks)
            setattr(network, name, synced)
        elif isinstance(layer, nn.Dropout):
            setattr(network, name, SharedDropout(layer.p, ranks).train(layer.training))
        else:
            share(layer, ranks)


class SharedDropout(nn.Module):
    """Dropout of which every process draws the mask of the whole pass, from one seed, and takes its slice."""

    def __init__(self, probability: float, ranks: Ranks) -> None:
        super().__init__()
        self.probability, self.ranks = probability, ranks

    def forward(self, x: Tensor) -> Tensor:
        if not self.training:
            return x
        whole = x.new_empty((len(x) * self.ranks.count, *x.shape[1:]))
        layout = torch.channels_last if x.is_contiguous(memory_format=torch.channels_last) else torch.contiguous_format
        mask = whole.contiguous(memory_format=layout).bernoulli_(1 - self.probability)
        return x * mask.chunk(self.ranks.count)[self.ranks.rank] / (1 - self.probability)


class SharedBatchNorm(nn.BatchNorm2d):
    """Batch norm whose statistics are those of all processes' slices, which are of one size."""

    ranks: Ranks

    @classmethod
    def of(cls, layer: nn.BatchNorm2d, ranks: Ranks) -> "SharedBatchNorm":
        """The layer's parameters and statistics in a shared layer."""
        shared = cls(layer.num_features, layer.eps, layer.momentum, device="meta")
        shared.ranks = ranks
        shared.weight, shared.bias = layer.weight, layer.bias
        for name, buffer in layer.named_buffers():
            setattr(shared, name, buffer)
        return shared

    def forward(self, x: Tensor) -> Tensor:
        if not self.training:
            return super().forward(x)
        values = x.float() if x.dtype in (torch.bfloat16, torch.float16) else x
        count = values.numel() // values.shape[1]
        slots = values.new_zeros((self.ranks.count, 2, values.shape[1]))
        variance, mean = torch.var_mean(values, dim=(0, 2, 3), correction=0)
        # Each process fills its own row; the sum of all is every process's row, for gradients too.
        slots[self.ranks.rank] = torch.stack([mean, variance])
        means, variances = _Sum.apply(slots).unbind(1)
        mean = means.mean(0)
        variance = (variances + (means - mean).square()).mean(0)
        counted, kept_mean, kept_variance = self.num_batches_tracked, self.running_mean, self.running_var
        assert counted is not None
        assert kept_mean is not None
        assert kept_variance is not None
        assert self.momentum is not None
        with torch.no_grad():
            whole = count * self.ranks.count
            counted.add_(1)
            kept_mean.lerp_(mean, self.momentum)
            kept_variance.lerp_(variance * (whole / max(whole - 1, 1)), self.momentum)
        factor = self.weight * torch.rsqrt(variance + self.eps)
        column = (1, -1, 1, 1)
        return (values * factor.view(column) + (self.bias - mean * factor).view(column)).to(x.dtype)


class _Sum(torch.autograd.Function):
    """Sum over all processes; so is its gradient."""

    @staticmethod
    def forward(_context: torch.autograd.function.FunctionCtx, values: Tensor) -> Tensor:
        values = values.clone()
        distributed.all_reduce(values)
        return values

    @staticmethod
    def backward(_context: torch.autograd.function.FunctionCtx, gradient: Tensor) -> Tensor:
        gradient = gradient.clone()
        distributed.all_reduce(gradient)
        return gradient
