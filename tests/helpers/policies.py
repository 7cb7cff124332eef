"""A training policy that tests change where it matters to them."""

from foggy_synscapes.training.policy import Policy


def changed(policy: Policy, **values: object) -> Policy:
    """A policy with other values, checked as one of a params file."""
    return Policy(**{**policy.model_dump(), **values})


POLICY = Policy(
    learning_rate=0.01,
    batch=4,
    crop=(32, 32),
    scale=(0.75, 1.5),
    loss="ohem",
    loss_stride=4,
    new_layer_rate=10.0,
)
