"""The order of samples is a pure function of the seed and the step."""

import pytest

from foggy_synscapes.training.streams import batch_indices, steps_per_epoch


def test_an_epoch_takes_every_sample():
    epoch = [batch_indices(0, step, 10, 4) for step in range(3)]
    flat = [index for batch in epoch for index in batch]
    assert all(len(batch) == 4 for batch in epoch)
    assert set(flat[:10]) == set(range(10))
    # The last batch is filled up from the epoch's own beginning.
    assert flat[10:] == flat[:2]


def test_epochs_and_seeds_differ():
    first = [index for step in range(5) for index in batch_indices(0, step, 20, 4)]
    second = [index for step in range(5, 10) for index in batch_indices(0, step, 20, 4)]
    other = [index for step in range(5) for index in batch_indices(1, step, 20, 4)]
    assert sorted(first) == sorted(second) == sorted(other) == list(range(20))
    assert first != second
    assert first != other


def test_any_step_can_be_asked_for_at_once():
    forward = [batch_indices(7, step, 9, 2) for step in range(12)]
    assert [batch_indices(7, step, 9, 2) for step in reversed(range(12))] == forward[::-1]


def test_the_paper_s_iterations():
    assert 50 * steps_per_epoch(498, 4) == 6250
    assert steps_per_epoch(24_500, 4) == 6125


@pytest.mark.parametrize("batch", [0, 6])
def test_batch_larger_than_the_list_is_an_error(batch):
    with pytest.raises(ValueError, match="batch"):
        batch_indices(0, 0, 5, batch)
