"""Which parameters of a network learn, how fast, and what is decayed or frozen, as a policy says."""

from torch import nn

from foggy_synscapes.networks.network import Network
from foggy_synscapes.training.policy import Policy


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
