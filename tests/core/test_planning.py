"""What a plan says of params, by hand; and what is found before a run begins."""

import json
from pathlib import Path
from typing import Any

import pytest

from foggy_synscapes import params
from foggy_synscapes.cli import main
from foggy_synscapes.errors import UsageError
from foggy_synscapes.planning import asked, checks, costs
from foggy_synscapes.planning.plan import plan

ROOT = Path(__file__).resolve().parents[2]
PAPER = params.load(ROOT / "params/paper.yaml")
SMOKE = params.load(ROOT / "params/smoke.yaml")


def found(overlay: dict[str, Any]) -> list[str]:
    chosen = params.check(overlay, "params.yaml")
    return checks.problems(chosen, asked.jobs(chosen))


def test_the_papers_tables_train_what_the_paper_trained() -> None:
    whole, _ = plan(PAPER, ["paper"])
    seen = {(each["network"], each["row"]): (each["images_seen"], each["validations"]) for each in whole.trainings}
    # RefineNet's row C is the public model itself: a job, but no training.
    assert ("refinenet", "C") not in seen
    assert whole.jobs["train"] == 10 == len(seen) + 1
    assert seen["refinenet", "FS-24500"] == seen["bisenet", "FS-24500"] == (24_500, 49)
    assert seen["bisenet", "C"] == (80 * 2975, 80)
    assert whole.jobs["evaluate"] == 2 * 2 * 5
    assert whole.frames == whole.foggy_images == 25_000


def test_each_beta_is_a_foggy_image_of_each_frame() -> None:
    full, _ = plan(params.load(ROOT / "params/discussion_full.yaml"))
    assert (full.frames, full.foggy_images) == (25_000, 5 * 25_000)
    # 1.2 MB an image, beside what models and predictions take.
    assert full.disk_bytes > 125_000 * 1.2e6


def test_a_single_shard_takes_its_own_frames_and_no_network() -> None:
    one, jobs = plan(PAPER, ["results/fog/beta_0.005/0007.tar"])
    assert [job.step.name for job in jobs] == ["scenes_synscapes", "filter", "fog_airlight", "fog"]
    assert (one.frames, one.foggy_images, one.trainings) == (500, 500, [])
    assert one.disk_bytes == round(500 * (1024 + 1.16 * 1440 * 720))
    assert sum(one.multiply_adds.values()) == 0


def test_recipes_take_next_to_no_disk() -> None:
    there = PAPER.model_copy(update={"fog": PAPER.fog.model_copy(update={"render": "on_the_fly"})})
    assert plan(there, ["fog"])[0].disk_bytes < plan(PAPER, ["fog"])[0].disk_bytes / 700


def test_multiply_adds_are_those_of_the_network_as_the_params_shape_it() -> None:
    assert costs.per_pixel(PAPER, "bisenet") * 1024 * 512 == pytest.approx(25.93e9, rel=1e-3)
    assert costs.per_pixel(SMOKE, "bisenet") < costs.per_pixel(PAPER, "bisenet") / 30
    (training,) = [each for each in PAPER.trainings() if (each.network, each.row) == ("bisenet", "FS-498")]
    # 500 images of Synscapes, 50 times.
    forward = costs.per_pixel(PAPER, "bisenet")
    assert costs.validations(PAPER, training) == pytest.approx(50 * 500 * 1440 * 720 * forward)


@pytest.mark.parametrize("test_set", ["foggy_driving", "foggy_zurich"])
def test_of_a_stand_in_the_drawn_images_count(test_set: str) -> None:
    assert costs.tested(PAPER, test_set) == {"foggy_driving": 101, "foggy_zurich": 40}[test_set]
    assert costs.tested(SMOKE, test_set) == {"foggy_driving": 4, "foggy_zurich": 5}[test_set]
    assert costs.pixels(SMOKE, test_set) == 64 * 128


def test_a_target_that_is_none_is_named() -> None:
    with pytest.raises(UsageError, match="tabels: no target"):
        asked.jobs(SMOKE, ["tabels"])


def test_the_json_holds_what_is_promised(capsys: pytest.CaptureFixture) -> None:
    path = str(ROOT / "params/smoke.yaml")
    assert main(["plan", "--params", path, "--json", "--images-per-second", "bisenet=0.5"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert {"jobs", "trainings", "frames", "disk_bytes", "multiply_adds"} <= set(document)
    assert set(document["trainings"][0]) == {"network", "row", "seed", "images_seen", "validations", "batch"}
    images = sum(each["images_seen"] for each in document["trainings"] if each["network"] == "bisenet")
    # Validations and evaluations take longer than the trainings alone.
    assert set(document["hours"]) == {"bisenet"}
    assert document["hours"]["bisenet"] > images / 0.5 / 3600


def test_no_hours_are_invented(capsys: pytest.CaptureFixture) -> None:
    path = str(ROOT / "params/smoke.yaml")
    assert main(["plan", "--params", path]) == 0
    assert " h at " not in capsys.readouterr().out
    assert main(["plan", "--params", path, "--images-per-second", "bisenet=2"]) == 0
    assert " h at 2 training images/s" in capsys.readouterr().out
    assert main(["plan", "--params", path, "--images-per-second", "bisenet=-1"]) == 2


def test_a_root_that_is_not_there_ends_the_check_and_warns_in_the_plan(
    tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    path = tmp_path / "params.yaml"
    path.write_text("scenes: {roots: {foggy_zurich: nowhere}}\n")
    assert main(["params", "--file", str(path), "--check"]) == 1
    assert "scenes.roots.foggy_zurich: nowhere does not exist" in capsys.readouterr().err
    assert main(["plan", "--params", str(path), "--json"]) == 0
    told = capsys.readouterr()
    assert "warning: scenes.roots.foggy_zurich: nowhere does not exist" in told.err
    assert json.loads(told.out)["jobs"]["train"] == 12


def test_a_root_that_nothing_asks_for_does_not_matter(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    overlay = {"scenes": {"roots": {"foggy_zurich": "nowhere"}}, "evaluate": {"test_sets": ["foggy_driving"]}}
    chosen = params.check(overlay, "params.yaml")
    # Its index is asked for by nothing but its test.
    jobs = asked.jobs(chosen, ["tables"])
    assert checks.problems(chosen, jobs) == []
    assert "scenes.roots.foggy_zurich" in checks.unused(chosen, jobs)


def test_a_network_that_is_not_trained_does_not_matter() -> None:
    overlay = {"train": {"networks": ["bisenet"], "refinenet": {"weights": "nowhere", "fine_tuning": {"batch": 4000}}}}
    chosen = params.check(overlay, "params.yaml")
    jobs = asked.jobs(chosen)
    assert checks.problems(chosen, jobs) == []
    assert checks.unused(chosen, jobs) == ["train.refinenet"]


def test_a_list_shorter_than_a_batch_is_named() -> None:
    (line,) = found({"train": {"bisenet": {"fine_tuning": {"batch": 128}}, "rows": ROWS}})[:1]
    assert "subset.partial.FC-498: lists 100 images, fewer than a batch of 128 when bisenet trains on it" in line


ROWS = {
    "C": None,
    **{row: {"length": {"epochs": 1}, "validate": {"epochs": 1}} for row in PAPER.train.rows if row != "C"},
}
del ROWS["FS-ImageNet"], ROWS["FC-FS-24500"]


@pytest.mark.parametrize(("real", "drawn"), [("foggy_cityscapes", "cityscapes"), ("cityscapes", "foggy_cityscapes")])
def test_foggy_cityscapes_and_cityscapes_are_both_real_or_both_drawn(tmp_path: Path, real: str, drawn: str) -> None:
    (line,) = found({"scenes": {"roots": {real: str(tmp_path)}}})
    assert f"{real} is real ({tmp_path}), but {drawn} is the stand-in" in line


def test_start_weights_that_are_not_there_are_named() -> None:
    (line,) = found({"train": {"bisenet": {"weights": "data/nowhere.safetensors"}}})
    assert "data/nowhere.safetensors, which bisenet C starts from, does not exist" in line
