"""A training policy that tests change where it matters to them."""

from foggy_synscapes.training.policy import Policy

POLICY = Policy(
    learning_rate=0.01,
    schedule="poly",
    power=0.9,
    momentum=0.9,
    weight_decay=0.0005,
    norm_weight_decay=0.0,
    batch=4,
    accumulate=1,
    crop=(32, 32),
    scale=(0.75, 1.5),
    flip=True,
    class_balance=False,
    loss="ohem",
    ohem_threshold=0.7,
    ohem_kept=0.0625,
    auxiliary_weight=1.0,
    loss_stride=4,
    backbone_rate=1.0,
    new_layer_rate=10.0,
    freeze_batch_norm=False,
)
