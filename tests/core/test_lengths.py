"""How long a network trains, in images: equal for every batch, and those of the paper in its params file."""

from pathlib import Path

import pytest

from foggy_synscapes import params
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.params.experiment import Training
from foggy_synscapes.params.training import Duration

ROOT = Path(__file__).resolve().parents[2]
PAPER = {(each.network, each.row): each for each in params.load(ROOT / "params/paper.yaml").trainings()}
FINE_TUNED = ("FC-498", "FS-24500", "FS-498", "FC-FS-498", "FC-FS-24500", "C-control")


def test_a_length_in_images_or_epochs_is_the_same_number_of_images_for_every_batch() -> None:
    for batch in (1, 2, 3, 4):
        assert 0 <= Duration(epochs=50).steps(498, batch) * batch - 50 * 498 < batch
        assert 0 <= Duration(images=24_900).steps(7, batch) * batch - 24_900 < batch
    assert Duration(iterations=7).steps(498, 4) == 7


@pytest.mark.parametrize("stated", [{}, {"images": 4, "epochs": 1}, {"images": 4, "epochs": 1, "iterations": 1}])
def test_a_length_is_stated_in_one_way(stated: dict) -> None:
    with pytest.raises(ValueError, match="give either images, epochs or iterations"):
        Duration(**stated)


# Section IV: 80 epochs of 2,975 images; IV.A: 50 epochs of 498 images, validated every epoch; one epoch of 24,500
# images, validated every 125 iterations (500 images). What it does not state: docs/deviations.md.
@pytest.mark.parametrize("network", ["refinenet", "bisenet"])
@pytest.mark.parametrize(
    ("row", "images", "validations"),
    [
        ("FC-498", 50 * 498, 50),
        ("FS-498", 50 * 498, 50),
        ("FC-FS-498", 50 * 498, 50),
        ("C-control", 50 * 498, 50),
        ("FS-24500", 24_500, 49),
        ("FS-ImageNet", 24_500, 49),
        ("FC-FS-24500", 24_500, 49),
    ],
)
def test_both_networks_see_the_papers_images_in_every_row(
    network: str, row: str, images: int, validations: int
) -> None:
    training = PAPER[network, row]
    assert (training.images_seen, training.validations) == (images, validations)
    assert training.policy.batch == {"refinenet": 1, "bisenet": 4}[network]


def test_bisenets_baseline_trains_80_epochs_and_refinenets_is_public() -> None:
    assert PAPER["bisenet", "C"][3:] == (2975, 59_500, 80 * 2975, 80)
    assert ("refinenet", "C") not in PAPER


@pytest.mark.parametrize("name", ["paper.yaml", "refinenet_as_printed.yaml", "discussion.yaml", "discussion_full.yaml"])
def test_fine_tunings_of_one_row_are_equally_long_whatever_the_network(name: str) -> None:
    seen: dict[str, set[tuple[int, int]]] = {}
    for each in params.load(ROOT / "params" / name).trainings():
        if each.row != "C":
            seen.setdefault(each.row, set()).add((each.images_seen, each.validations))
    assert {len(lengths) for lengths in seen.values()} == {1}


def test_what_the_printed_policy_says_of_refinenet_is_an_overlay_of_the_paper() -> None:
    policy = {each.row: each.policy for each in params.load(ROOT / "params/refinenet_as_printed.yaml").trainings()}
    for row in FINE_TUNED:
        assert (policy[row].batch, policy[row].learning_rate, policy[row].schedule) == (4, 0.001, "poly")
        assert policy[row].crop == PAPER["refinenet", row].policy.crop


def test_where_the_public_model_cannot_be_had_refinenets_baseline_is_trained_from_imagenet() -> None:
    """As long as the paper's baseline of BiSeNet, by the settings of RefineNet's released training code."""
    whole = params.load(ROOT / "params/refinenet_baseline.yaml")
    plan = {(each.network, each.row): each for each in whole.trainings()}
    added = plan.pop(("refinenet", "C"))
    assert plan == PAPER
    assert (added.listed, added.images_seen, added.validations) == (2975, PAPER["bisenet", "C"].images_seen, 16)
    policy = added.policy
    assert (policy.learning_rate, policy.backbone_rate, policy.batch, policy.freeze_batch_norm) == (5e-4, 0.1, 1, True)
    assert (policy.crop, policy.scale, policy.class_balance) == ((600, 600), (0.7, 1.3), True)
    started = params.load(ROOT / "params/paper.yaml").train.weights("refinenet", "FS-ImageNet")
    assert whole.train.weights("refinenet", "C") == started


def test_the_full_discussion_has_five_betas_three_mixes_both_networks_and_three_seeds() -> None:
    full = params.load(ROOT / "params/discussion_full.yaml")
    kinds = full.subset.kinds()
    betas = ["0.005", "0.01", "0.02", "0.03", "0.06"]
    assert [entry.beta for entry in kinds["partial"].values()] == betas
    assert [entry.beta for row, entry in kinds["pure"].items() if row != "FS-ImageNet"] == betas
    assert [entry.ratio for entry in kinds["mixed"].values()] == [(2, 1), (1, 1), (1, 5)]
    assert full.train.networks == ["refinenet", "bisenet"]
    assert full.train.seeds == ["0", "1", "2"]
    assert {type(each) for each in full.trainings()} == {Training}


def test_a_file_is_laid_on_its_base_which_may_have_one_too(tmp_path: Path) -> None:
    (tmp_path / "first.yaml").write_text("train: {threads: 3, workers: 2}")
    (tmp_path / "second.yaml").write_text("base: first.yaml\ntrain: {threads: 4}")
    (tmp_path / "third.yaml").write_text("base: second.yaml\nfigures: {images: 1}")
    found = params.load(tmp_path / "third.yaml")
    assert (found.train.threads, found.train.workers, found.figures.images) == (4, 2, 1)


@pytest.mark.parametrize("base", ["own.yaml", "[own.yaml]", "none.yaml"])
def test_a_base_that_is_no_other_file_is_refused(tmp_path: Path, base: str) -> None:
    (tmp_path / "own.yaml").write_text(f"base: {base}")
    with pytest.raises(FoggyError, match=r"own\.yaml: base: name another params file|none\.yaml: missing"):
        params.load(tmp_path / "own.yaml")


def test_a_circle_of_bases_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text("base: b.yaml")
    (tmp_path / "b.yaml").write_text("base: a.yaml")
    with pytest.raises(FoggyError, match=r"b\.yaml: base: .* got 'a\.yaml'"):
        params.load(tmp_path / "a.yaml")


def test_air_that_is_clearer_than_fog_is_warned_of_by_its_visibility(
    tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    from foggy_synscapes.cli import main

    assert params.load(ROOT / "params/discussion_full.yaml").warnings() == []
    path = tmp_path / "light.yaml"
    text = (ROOT / "params.yaml").read_text().replace('"0.005"', '"0.002"')
    path.write_text(text)
    assert main(["params", "--file", str(path), "--check"]) == 0
    said = capsys.readouterr()
    assert said.out == f"{path}: good\n"
    assert "warning: fog.betas: beta 0.002 1/m is a visibility of 1,498 m" in said.err
