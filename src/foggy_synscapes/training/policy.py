"""How a network is trained: learning rates, their schedule, and what is decayed or frozen."""

from dataclasses import dataclass

from torch import nn

from foggy_synscapes.networks.network import Network


@dataclass(frozen=True)
class Policy:
    """One training policy; nothing of it has a default, so that every constant has a source in the params file.

    learning_rate : at the first step; momentum : of stochastic gradient descent, without Nesterov's correction
    schedule : "poly", learning_rate * (1 - step / steps) ** power, or "constant"
    weight_decay : of weights; norm_weight_decay : of batch norm's parameters and of biases
    batch : images a step; accumulate : forward passes into which they are split
    crop : rows and columns in pixels; scale : smallest and largest factor of resizing; flip : left and right
    class_balance : cut crops around pixels of classes that are drawn alike (see `augment.augment`)
    loss : "cross_entropy", or "ohem" with ohem_threshold and ohem_kept (see `losses.hard_examples`)
    auxiliary_weight : factor of the auxiliary outputs' losses; loss_stride : pixels between those that a loss looks at
    backbone_rate, new_layer_rate : factors of the learning rate, of the backbone and of all other layers
    freeze_batch_norm : keep running statistics and parameters of batch norm as they are
    """

    learning_rate: float
    schedule: str
    power: float
    momentum: float
    weight_decay: float
    norm_weight_decay: float
    batch: int
    accumulate: int
    crop: tuple[int, int]
    scale: tuple[float, float]
    flip: bool
    class_balance: bool
    loss: str
    ohem_threshold: float
    ohem_kept: float
    auxiliary_weight: float
    loss_stride: int
    backbone_rate: float
    new_layer_rate: float
    freeze_batch_norm: bool

    def rate(self, step: int, steps: int) -> float:
        """Learning rate of a step, counted from 0, before the factors of `parameter_groups`.

        Source of the polynomial: Zhao et al., Pyramid Scene Parsing Network, CVPR 2017, section 5.1.
        """
        if not 0 <= step < steps:
            raise ValueError(f"step: {step}, expected 0 to {steps - 1}")
        if self.schedule == "constant":
            return self.learning_rate
        if self.schedule == "poly":
            return self.learning_rate * (1 - step / steps) ** self.power
        raise ValueError(f"schedule: {self.schedule!r}, expected poly or constant")


def parameter_groups(network: Network, policy: Policy) -> list[dict]:
    """Groups for an optimiser, each with `factor` of the learning rate and `weight_decay`; without what is frozen."""
    norms = {id(p) for m in network.modules() if isinstance(m, nn.BatchNorm2d) for p in m.parameters()}
    groups: dict[tuple[float, float], list[nn.Parameter]] = {}
    for name, parameter in network.named_parameters():
        if not parameter.requires_grad:
            continue
        factor = policy.backbone_rate if name.startswith("backbone.") else policy.new_layer_rate
        plain = id(parameter) in norms or name.endswith(".bias")
        decay = policy.norm_weight_decay if plain else policy.weight_decay
        groups.setdefault((factor, decay), []).append(parameter)
    return [{"params": p, "factor": factor, "weight_decay": decay} for (factor, decay), p in groups.items()]


def set_training(network: Network, policy: Policy) -> None:
    """Training mode; batch norm stays in evaluation mode, and its parameters get no gradient, where it is frozen."""
    network.train()
    if policy.freeze_batch_norm:
        for module in network.modules():
            if isinstance(module, nn.BatchNorm2d):
                module.eval().requires_grad_(False)
