"""Losses against values worked out by hand, and at the extremes."""

import math

import policies
import pytest
import torch

from foggy_synscapes.training.losses import cross_entropy, grid, hard_examples, pixel_losses, total

POLICY = policies.changed(policies.POLICY, loss="cross_entropy")


def logits_for(probabilities):
    """Logits (1, 2, 1, N) that give class 0 these probabilities."""
    p = torch.tensor(probabilities, dtype=torch.float64)
    return torch.stack([p.log(), (1 - p).log()]).float().view(1, 2, 1, -1)


def test_cross_entropy_is_the_mean_over_labelled_pixels():
    targets = torch.tensor([[[0, 1, 255]]], dtype=torch.uint8)
    losses, labelled, _ = pixel_losses(logits_for([0.5, 0.75, 0.001]), targets, True)
    assert float(cross_entropy(losses, labelled)) == pytest.approx((math.log(2) + math.log(4)) / 2, rel=1e-6)


def ohem(probabilities, targets, threshold=0.7, kept=0.0):
    losses, labelled, _ = pixel_losses(logits_for(probabilities), torch.tensor([[targets]], dtype=torch.uint8), True)
    return float(hard_examples(losses, labelled, threshold, kept))


def test_only_pixels_below_the_threshold_count():
    assert ohem([0.9, 0.6, 0.3], [0, 0, 0]) == pytest.approx(-(math.log(0.6) + math.log(0.3)) / 2, rel=1e-5)


def test_at_least_the_given_share_counts_even_if_easy():
    # Half of four pixels: the two hardest, though none is below the threshold.
    assert ohem([0.99, 0.9, 0.8, 0.95], [0] * 4, kept=0.5) == pytest.approx(
        -(math.log(0.8) + math.log(0.9)) / 2, rel=1e-5
    )


def test_share_is_of_all_pixels_but_ignored_ones_never_count():
    # 3 of 4 pixels are asked for, 2 are labelled: both count, easy as they are.
    assert ohem([0.9, 0.8, 0.1, 0.1], [0, 0, 255, 255], kept=0.75) == pytest.approx(
        -(math.log(0.9) + math.log(0.8)) / 2, rel=1e-5
    )


def test_easy_pixels_beyond_the_share_give_no_loss():
    assert ohem([0.9, 0.9], [0, 0], kept=0.0) == 0.0


@pytest.mark.parametrize("loss", ["cross_entropy", "ohem"])
@pytest.mark.parametrize("scale", [1e4, 1e30])
def test_extreme_logits_stay_finite(loss, scale):
    logits = (torch.randn(2, 19, 4, 4, generator=torch.Generator().manual_seed(0)) * scale).requires_grad_()
    targets = torch.randint(0, 19, (2, 8, 8), dtype=torch.uint8)
    value = total([logits], targets, True, policies.changed(POLICY, loss=loss))
    value.backward()
    assert math.isfinite(value.item())
    assert torch.isfinite(logits.grad).all()


@pytest.mark.parametrize("loss", ["cross_entropy", "ohem"])
def test_nothing_labelled_gives_zero_not_nan(loss):
    logits = torch.randn(1, 19, 2, 2, requires_grad=True)
    value = total([logits], torch.full((1, 8, 8), 255, dtype=torch.uint8), True, policies.changed(POLICY, loss=loss))
    value.backward()
    assert value.item() == 0.0
    assert float(logits.grad.abs().sum()) == 0.0


def test_auxiliary_losses_are_weighted_and_added():
    logits, targets = torch.randn(1, 19, 2, 2), torch.zeros((1, 4, 4), dtype=torch.uint8)
    one = float(total([logits], targets, True, POLICY))
    halved = policies.changed(POLICY, auxiliary_weight=0.5)
    assert float(total([logits] * 3, targets, True, halved)) == pytest.approx(2 * one)


def test_stride_1_is_the_published_loss():
    logits, targets = torch.randn(1, 19, 2, 3), torch.randint(0, 19, (1, 8, 12), dtype=torch.uint8)
    whole = torch.nn.functional.interpolate(logits, size=(8, 12), mode="bilinear", align_corners=True)
    expected = torch.nn.functional.cross_entropy(whole, targets.long())
    assert float(total([logits], grid(targets, 1, True), True, POLICY)) == pytest.approx(float(expected), rel=1e-6)


@pytest.mark.parametrize("corners", [True, False])
def test_thinned_pixels_are_those_whose_enlarged_value_is_compared(corners):
    # A map that equals its own row number: whatever the stride, logits and targets must speak of the same place.
    rows = torch.arange(96, dtype=torch.uint8).view(1, 96, 1).expand(1, 96, 64)
    thin = grid(rows, 8, corners)
    assert thin.shape == (1, 12, 8)
    enlarged = torch.nn.functional.interpolate(
        thin[:, None].double(), size=(96, 64), mode="bilinear", align_corners=corners
    )[0, 0, :, 0]
    inner = slice(8, 88)
    assert float((enlarged[inner] - torch.arange(96)[inner]).abs().max()) <= 0.75
