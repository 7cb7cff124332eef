"""The budget says what the params say, and the pages quote the budget."""

from pathlib import Path

import budget
import pytest

from foggy_synscapes import params

ROOT = Path(__file__).resolve().parents[2]
PAPER = params.load(ROOT / "params/paper.yaml")


@pytest.fixture(scope="module")
def costs() -> dict[tuple[str, str], budget.Cost]:
    return {(each.network, each.row): each for each in budget.costs(PAPER)}


def test_every_row_of_every_network_is_counted(costs: dict[tuple[str, str], budget.Cost]) -> None:
    assert set(costs) == {(network, row) for network in PAPER.train.networks for row in PAPER.subset.rows()}
    assert min(each.evaluations for each in costs.values()) > 0


def test_images_are_those_that_are_drawn(costs: dict[tuple[str, str], budget.Cost]) -> None:
    drawn = {(each.network, each.row): each.images_seen for each in PAPER.trainings()}
    assert {place: each.images for place, each in costs.items() if each.images} == drawn
    assert costs["refinenet", "C"].steps == 0
    # One epoch of 24,500, from ImageNet's weights: as long as FS-24500, and not the baseline's 80 epochs.
    assert costs["bisenet", "FS-ImageNet"].images == costs["bisenet", "FS-24500"].images == 24_500


def test_a_row_by_hand(costs: dict[tuple[str, str], budget.Cost]) -> None:
    # BiSeNet has 25.9 G multiply-adds at 1024 x 512: 24,900 crops of 1024 x 1024, forward and backward.
    assert costs["bisenet", "FC-498"].steps == pytest.approx(24_900 * 3 * 2 * 25.93e9, rel=1e-3)
    # 50 times 52 images of 2048 x 1024.
    assert costs["bisenet", "FC-498"].validations == pytest.approx(50 * 52 * 4 * 25.93e9, rel=1e-3)


def test_three_seeds_cost_three_times_as_much() -> None:
    full = params.load(ROOT / "params/discussion_full.yaml")
    one = full.model_copy(update={"train": full.train.model_copy(update={"seeds": ["0"]})})
    assert budget.hours(budget.costs(full)) == pytest.approx(3 * budget.hours(budget.costs(one)))


def test_the_pages_quote_it() -> None:
    assert budget.report(PAPER) in (ROOT / "docs/scale.md").read_text()
    hours = f"{budget.hours(budget.costs(PAPER)):.0f} hours"
    readme = " ".join((ROOT / "README.md").read_text().split())
    assert f"trainings and evaluations of `params/paper.yaml` are {hours} where a GPU sustains" in readme


def test_the_deviations_name_the_mixes_as_they_are() -> None:
    page, mixed = (ROOT / "docs/deviations.md").read_text(), PAPER.subset.kinds()["mixed"]
    for row, text in (("FC-FS-498", "(498 of Foggy Synscapes, 249 of"), ("FC-FS-24500", "(24,500 and 12,250,")):
        entry = mixed[row]
        more = entry.counts()[0] - entry.train
        assert f"{entry.train:,}" in text
        assert f"{more:,}" in text
        assert f"`{row}` {text}" in page
