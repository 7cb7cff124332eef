"""A training resumes to the last bit, keeps the best snapshot, and says what is wrong."""

from dataclasses import replace

import numpy as np
import policies
import pytest
import torch

from foggy_synscapes.networks import NetworkConfig
from foggy_synscapes.networks.network import build
from foggy_synscapes.networks.weights import Model, Preprocessing, dump
from foggy_synscapes.training import loop
from foggy_synscapes.training.learner import Arithmetic, Learner, NotFiniteError

pytestmark = pytest.mark.usefixtures("one_thread")

BISENET = NetworkConfig("bisenet", "resnet18", width=8, decoder=4, classes=4)
REFINENET = NetworkConfig("refinenet", "resnet18", width=8, decoder=4, classes=4, auxiliary=False)
POLICY = policies.changed(policies.POLICY, learning_rate=0.05, batch=2, new_layer_rate=2.0)
PLAN = loop.Plan(steps=10, validate_every=4, curve_every=3, snapshot_every=1, seed=5, workers=0)


class Samples:
    """Samples that are in memory."""

    def __init__(self, found):
        self.found, self.count = found, len(found)

    def load(self, index):
        return self.found[index]

    def name(self, index):
        return f"image {index}"


def samples(count=5, seed=0):
    """Blocks of four classes, each of its own colour."""
    random = np.random.default_rng(seed)
    palette = np.array([(20, 20, 20), (220, 30, 30), (30, 220, 30), (40, 40, 230)], np.uint8)
    found = []
    for _ in range(count):
        labels = np.kron(random.integers(0, 4, (3, 3)), np.ones((16, 16))).astype(np.uint8)
        found.append((palette[labels], labels))
    return Samples(found)


class Killed(Exception):
    pass


def train(config=BISENET, policy=POLICY, plan=PLAN, kill_at=None, snapshot=None, **changes):
    """One run; returns the model file and the curve, or, where it was killed, the last snapshot."""
    torch.manual_seed(1)
    network = build(config)
    saved = []

    def report(done, loss, rate):
        if done == kill_at:
            raise Killed

    arguments = {"training": samples(), "validation": samples(3, seed=9), **changes}
    try:
        outcome = loop.train(
            Model(network, Preprocessing()),
            policy,
            plan,
            Arithmetic(),
            save=saved.append,
            settings={"a": 1},
            snapshot=snapshot,
            report=report,
            **arguments,
        )
    except Killed:
        return saved[-1] if saved else snapshot
    network.load_state_dict(outcome.best)
    return dump(network, Preprocessing()), outcome.curve


@pytest.fixture(scope="module")
def whole():
    torch.set_num_threads(1)
    return {config.name: train(config) for config in (BISENET, REFINENET)}


@pytest.mark.parametrize("config", [BISENET, REFINENET], ids=["bisenet", "refinenet"])
def test_killed_at_every_step_it_ends_in_the_same_bytes(config, whole):
    snapshot = None
    for step in range(1, PLAN.steps):
        snapshot = train(config, kill_at=step, snapshot=snapshot)
    assert train(config, snapshot=snapshot) == whole[config.name]


@pytest.mark.parametrize("every", [3, 4])
def test_killed_between_snapshots_it_ends_in_the_same_bytes(every, whole):
    plan = replace(PLAN, snapshot_every=every)
    snapshot = None
    for step in (2, 5, 7, 8):
        snapshot = train(plan=plan, kill_at=step, snapshot=snapshot)
    assert train(plan=plan, snapshot=snapshot) == whole["bisenet"]


def test_loader_workers_change_no_byte(whole):
    plan = replace(PLAN, workers=2)
    snapshot = train(plan=plan, kill_at=6)
    assert train(plan=plan, snapshot=snapshot) == whole["bisenet"]
    assert train(snapshot=snapshot) == whole["bisenet"]


def test_the_lowest_validation_loss_is_what_is_kept():
    weights = []

    def spy(learner, *_):
        weights.append({name: tensor.clone() for name, tensor in learner.network.state_dict().items()})
        return [3.0, 1.0, 2.0][len(weights) - 1], 0.0

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Learner, "validate", spy)
        model, curve = train()
    assert len(weights) == 3
    network = build(BISENET)
    network.load_state_dict(weights[1])
    assert dump(network, Preprocessing()) == model
    assert [row[4] for row in curve if row[4] is not None] == [3.0, 1.0, 2.0]


def test_loss_falls_and_the_curve_is_complete():
    plan = replace(PLAN, steps=40, validate_every=20, curve_every=10, snapshot_every=100)
    policy = policies.changed(POLICY, batch=5, crop=(64, 64), scale=(1.0, 1.0), loss_stride=2)
    _, curve = train(replace(BISENET, width=8), policy, plan)
    assert [row[0] for row in curve] == [10, 20, 30, 40]
    assert [row[1] for row in curve] == [10, 20, 30, 40]
    assert curve[-1][3] < 0.85 * curve[0][3]
    assert curve[-1][4] < 0.6 * curve[1][4]
    assert curve[-1][5] > 35  # percent; chance is below 20
    assert [row[4] is None for row in curve] == [True, False, True, False]


def test_accumulated_passes_keep_the_samples_of_a_step():
    policy = policies.changed(POLICY, freeze_batch_norm=True, loss="cross_entropy", learning_rate=0.01)
    _, whole = train(policy=policy)
    _, parts = train(policy=policies.changed(policy, accumulate=2))
    # Not the same number of labelled pixels in each half, so the means differ a little.
    assert [row[3] for row in parts] == pytest.approx([row[3] for row in whole], rel=0.05)


def test_bfloat16_stays_near_float32():
    plan = replace(PLAN, steps=4)
    torch.manual_seed(1)
    outcome = loop.train(
        Model(build(BISENET), Preprocessing()),
        POLICY,
        plan,
        Arithmetic(precision="bfloat16"),
        samples(),
        samples(3, seed=9),
        save=lambda data: None,
        settings={},
    )
    _, curve = train(plan=plan)
    assert outcome.curve[0][3] == pytest.approx(curve[0][3], rel=0.1)
    assert outcome.best["backbone.conv1.weight"].dtype == torch.float32


def test_diverged_loss_names_step_and_images():
    with pytest.raises(NotFiniteError, match=r"at step \d+, on image \d, image \d"):
        train(policy=policies.changed(POLICY, learning_rate=1e30))


def test_batch_larger_than_the_list_is_an_error():
    with pytest.raises(ValueError, match="batch: 6 images a step, but the list has 5"):
        train(policy=policies.changed(POLICY, batch=6))


def test_zero_iterations_are_an_error():
    with pytest.raises(ValueError, match="steps: 0"):
        replace(PLAN, steps=0)


def test_validation_without_a_labelled_pixel_is_an_error():
    blank = Samples([(np.zeros((32, 32, 3), np.uint8), np.full((32, 32), 255, np.uint8))] * 2)
    with pytest.raises(ValueError, match="labelled"):
        train(validation=blank)


def test_images_of_any_and_of_mixed_size_are_validated():
    sizes = [(33, 40), (33, 40), (40, 47)]
    found = [(np.zeros((*size, 3), np.uint8), np.zeros(size, np.uint8)) for size in sizes]
    _, curve = train(validation=Samples(found))
    assert curve[-1][4] is not None
