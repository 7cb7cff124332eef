"""Two processes together compute what one computes on the whole batch."""

import numpy as np
import policies
import processes
import pytest
import torch

from foggy_synscapes.networks import NetworkConfig
from foggy_synscapes.networks.network import build
from foggy_synscapes.networks.weights import Model, Preprocessing, dump
from foggy_synscapes.training import loop, losses
from foggy_synscapes.training.learner import Arithmetic, NotFiniteError
from foggy_synscapes.training.ranks import ALONE, Ranks, RanksError, share

pytestmark = pytest.mark.usefixtures("one_thread")

PLAN = loop.Plan(steps=6, validate_every=3, curve_every=1, snapshot_every=2, seed=5, workers=0)
BISENET = NetworkConfig("bisenet", "resnet18", width=8, decoder=4, classes=4)
REFINENET = NetworkConfig("refinenet", "resnet18", width=8, decoder=4, classes=4, auxiliary=False)
# Of BiSeNet the fewest hard pixels count, and each process has its own; its batch norm learns. RefineNet drops out.
# At this rate rounding grows to 3e-6 in the second step, and gradients that are wrong by a tenth change it by 5e-4.
HARD = policies.changed(
    policies.POLICY, learning_rate=1e-4, batch=4, ohem_threshold=0.01, ohem_kept=0.3, new_layer_rate=1.0
)
FROZEN = policies.changed(policies.POLICY, batch=4, accumulate=2, loss="cross_entropy", freeze_batch_norm=True)


class Samples:
    """Blocks of four classes, each of its own colour; one half of the images is hardly labelled."""

    count = 5

    def load(self, index):
        random = np.random.default_rng(index)
        labels = np.kron(random.integers(0, 4, (3, 3)), np.ones((16, 16))).astype(np.uint8)
        image = np.stack([labels * 60, 200 - labels * 60, labels * 20], axis=-1).astype(np.uint8)
        if index % 2:
            labels[8:] = 255
        return image, labels

    def name(self, index):
        return f"image {index}"


def train(ranks, config, policy, snapshot=None, settings=None):
    torch.manual_seed(1)
    network, saved = build(config), []
    outcome = loop.train(
        Model(network, Preprocessing()),
        policy,
        PLAN,
        Arithmetic(),
        Samples(),
        Samples() if ranks.first else None,
        save=saved.append,
        settings=settings or {},
        snapshot=snapshot,
        ranks=ranks,
    )
    if not ranks.first:
        return saved
    network.load_state_dict(outcome.best)
    return dump(network, Preprocessing()), outcome.curve, saved


def interrupted(ranks, config, policy):
    """Train to the end, and again from the first snapshot, which every process reads."""
    whole = train(ranks, config, policy)
    saved = [whole[2][0] if ranks.first else None]
    torch.distributed.broadcast_object_list(saved)
    again = train(ranks, config, policy, saved[0])
    return (*whole, again[:2]) if ranks.first else whole


# Batch norm over a few pixels makes rounding errors grow a hundredfold a step, in one process as in two: weights that
# differ by 1e-7 drift as far apart. So of BiSeNet the first steps are compared, and batch norm alone in float64 below.
@pytest.mark.parametrize(
    ("config", "policy", "steps", "tolerance"),
    [(BISENET, HARD, 2, 1e-4), (REFINENET, FROZEN, PLAN.steps, 1e-6)],
    ids=["bisenet", "refinenet"],
)
def test_two_processes_follow_the_curve_of_one_and_resume_to_the_same_bytes(config, policy, steps, tolerance):
    _, curve, _ = train(ALONE, config, policy)
    (model, shared, _, again), saved_by_the_second = processes.run(2, interrupted, config, policy)
    assert len(shared) == PLAN.steps
    for ours, theirs in zip(shared[:steps], curve[:steps], strict=True):
        assert [value or 0 for value in ours] == pytest.approx([value or 0 for value in theirs], rel=tolerance)
    assert again == (model, shared)
    assert saved_by_the_second == []


def learn(ranks, images):
    """Gradients and statistics of two layers of batch norm and one of dropout, in float64."""
    torch.manual_seed(4)
    network = torch.nn.Sequential(
        torch.nn.Conv2d(3, 4, 3),
        torch.nn.BatchNorm2d(4),
        torch.nn.Dropout(0.5),
        torch.nn.Conv2d(4, 2, 3, stride=3),
        torch.nn.BatchNorm2d(2),
    ).double()
    if ranks.count > 1:
        share(network, ranks)
    outputs = network(images.chunk(ranks.count)[ranks.rank])
    (outputs * outputs.detach().sin()).sum().backward()
    values = [ranks.total(parameter.grad) for parameter in network.parameters()]
    return torch.cat(
        [value.detach().flatten().double() for value in [*values, *network.state_dict().values()]]
    ).tolist()


def test_batch_norm_and_dropout_are_those_of_the_whole_batch():
    images = torch.rand(4, 3, 8, 8, dtype=torch.float64, generator=torch.Generator().manual_seed(6))
    whole = learn(ALONE, images)
    assert len(whole) > 300
    for shared in processes.run(2, learn, images):
        assert shared == pytest.approx(whole, rel=1e-10, abs=1e-12)


def part(ranks, values, labelled):
    slices = values.chunk(ranks.count)[ranks.rank], labelled.chunk(ranks.count)[ranks.rank]
    return float(losses.hard_examples(*slices, 0.7, 0.25, ranks)), float(losses.cross_entropy(*slices, ranks))


@pytest.mark.parametrize("level", [0.01, 1.0], ids=["the hardest of all", "all above the threshold"])
def test_the_loss_over_all_pixels_is_the_sum_of_the_parts(level):
    random = torch.Generator().manual_seed(3)
    values = torch.rand(64, generator=random) * level
    values[32:] *= 0.1  # nearly all hard pixels are the first process's
    labelled = torch.rand(64, generator=random) < 0.7
    parts = torch.tensor(processes.run(2, part, values * labelled, labelled))
    assert parts.sum(0).tolist() == pytest.approx(part(ALONE, values * labelled, labelled), rel=1e-6)


def fails(ranks, kind):
    if kind == "other settings":
        train(ranks, REFINENET, FROZEN, settings={"seed": ranks.rank})
    elif kind == "diverged":
        train(ranks, REFINENET, policies.changed(FROZEN, learning_rate=1e30))
    elif ranks.rank == 1:
        raise ValueError("only here")


@pytest.mark.parametrize(
    ("kind", "error", "message"),
    [
        ("other settings", RanksError, "read different files, params or code"),
        ("diverged", NotFiniteError, r"loss is (nan|inf) at step \d+, on image \d, image \d, image \d, image \d"),
        ("one alone", ValueError, "only here"),
    ],
)
def test_a_failure_ends_all_processes_with_one_message(kind, error, message):
    found = processes.run(2, fails, kind)
    spoken = [each for each in found if not isinstance(each, SystemExit)]
    assert [each.code for each in found if isinstance(each, SystemExit)] == [1]
    assert len(spoken) == 1
    assert isinstance(spoken[0], error)
    with pytest.raises(error, match=message):
        raise spoken[0]


def test_a_batch_that_cannot_be_shared_is_an_error():
    with pytest.raises(RanksError, match=r"batch: 4 images in 1 passes .* by 3 processes.* multiple of 3"):
        Ranks(0, 3).places(4, 1)
