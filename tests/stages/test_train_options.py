"""Options of `foggy train` that change how it computes or what one sees of it."""

import csv
import json
import sys
from pathlib import Path

import pytest
import torch
import yaml
from training_project import hashes, interrupt, project_in, train, write_lists

FOLDER = Path("results/train/bisenet/C/seed-0")
MODEL = "model.safetensors"


@pytest.fixture
def project(tmp_path, monkeypatch):
    """A project to train in; gives a function that changes its params."""
    return project_in(tmp_path, monkeypatch)


def record():
    return json.loads((FOLDER / "run.json").read_text())


def test_the_precision_decides_what_is_learned_and_is_recorded(project):
    assert train() == 0
    exact = hashes()[MODEL]
    project(("precision",), "bfloat16")
    assert train() == 0
    assert record()["params"]["train"]["precision"] == "bfloat16"
    assert hashes()[MODEL] != exact


def test_a_compiled_network_learns_the_same(project, monkeypatch):
    assert train() == 0
    with open(FOLDER / "curves.csv") as file:
        plain = [float(row["train_loss"]) for row in csv.DictReader(file)]
    whole, calls = torch.compile, []

    def quickly(module):
        calls.append(module)
        return whole(module, backend="eager")  # traced as ever; only the minutes of code generation are left out

    monkeypatch.setattr(torch, "compile", quickly)
    project(("compile",), True)
    assert train() == 0
    assert len(calls) == 1
    with open(FOLDER / "curves.csv") as file:
        assert [float(row["train_loss"]) for row in csv.DictReader(file)] == pytest.approx(plain, rel=1e-4)
    assert record()["params"]["train"]["compile"] is True


def test_a_failing_compiler_names_the_setting(project, monkeypatch, capsys):
    from torch._dynamo.exc import BackendCompilerFailed

    def fail(_module):
        def call(_images):
            raise BackendCompilerFailed(fail, RuntimeError("no compiler found"), [])

        return call

    monkeypatch.setattr(torch, "compile", fail)
    project(("compile",), True)
    assert train() == 1
    message = capsys.readouterr().err
    assert "no compiler found" in message
    assert "Set train.compile to false" in message
    assert not FOLDER.exists()


def test_live_curves_show_every_row_once_and_change_no_result(project, monkeypatch):
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

    assert train() == 0
    plain = hashes()
    project(("live",), ["dvclive", "tensorboard"])
    for name in plain:
        (FOLDER / name).unlink()
    interrupt(monkeypatch, 2)
    assert train() == 0
    assert hashes() == plain

    with open(FOLDER / "curves.csv") as file:
        rows = list(csv.DictReader(file))
    for name, column in (("train/loss", "train_loss"), ("validation/miou", "validation_miou")):
        steps = [int(row["step"]) for row in rows if row[column]]
        values = [float(row[column]) for row in rows if row[column]]
        assert len(steps) > 1
        path = Path(f"results/logs/dvclive/bisenet/C/seed-0/plots/metrics/{name}.tsv")
        with open(path) as file:
            found = [list(row.values()) for row in csv.DictReader(file, delimiter="\t")]
        assert [int(step) for step, _ in found] == steps
        assert [float(value) for _, value in found] == pytest.approx(values)
        events = EventAccumulator("results/logs/tensorboard/bisenet/C/seed-0").Reload().Scalars(name)
        assert [event.step for event in events] == steps
        assert [event.value for event in events] == pytest.approx(values)


def test_a_tool_that_is_not_installed_is_named(project, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "dvclive", None)
    project(("live",), ["dvclive"])
    assert train() == 1
    assert "train.live: dvclive is not installed" in capsys.readouterr().err


def direct(project, entry):
    """A row that starts from weights, beside C, with its own entry in `rows`."""
    write_lists("FS-direct")
    project(("clear", "FS-direct"), {"train": 4, "validation": 2}, section="subset")
    project(("from_weights",), ["C", "FS-direct"])
    project(("rows", "FS-direct"), entry)


def test_a_row_from_weights_may_last_as_long_as_it_says(project):
    direct(project, {"length": {"iterations": 2}, "validate": {"iterations": 1}})
    assert train(row="FS-direct") == 0
    rows = Path("results/train/bisenet/FS-direct/seed-0/curves.csv").read_text().splitlines()
    assert [row.split(",")[0] for row in rows] == ["step", "1", "2"]
    direct(project, None)
    assert train(row="FS-direct") == 0
    assert train() == 0
    # The same start, list, policy and length as row C.
    assert hashes(row="FS-direct")[MODEL] == hashes()[MODEL]


def test_a_row_may_start_from_weights_and_by_a_policy_of_its_own(project, capsys):
    assert train() == 0
    Path("start.safetensors").write_bytes((FOLDER / MODEL).read_bytes())
    length = {"length": {"iterations": 2}, "validate": {"iterations": 1}}
    direct(project, length | {"start": {"bisenet": {"weights": "start.safetensors"}}})
    assert train(row="FS-direct") == 0
    by_baseline = hashes(row="FS-direct")[MODEL]
    policy = yaml.safe_load(Path("params.yaml").read_text())["train"]["bisenet"]["fine_tuning"]
    project(("rows", "FS-direct", "start", "bisenet", "policy"), policy)
    project(("bisenet", "baseline"), None)
    project(("bisenet", "weights"), "start.safetensors")
    project(("networks",), ["bisenet"])
    assert train(row="FS-direct") == 0
    assert hashes(row="FS-direct")[MODEL] != by_baseline
    run = json.loads(Path("results/train/bisenet/FS-direct/seed-0/run.json").read_text())
    assert "start.safetensors" in run["inputs"]
    start = run["params"]["train"]["rows"]["FS-direct"]["start"]["bisenet"]
    assert start["policy"]["learning_rate"] == policy["learning_rate"]
    assert start["weights"] == "imported"

    project(("rows", "FS-direct", "start", "bisenet", "policy"), None)
    assert train(row="FS-direct") == 1
    assert "rows.FS-direct.start.bisenet.policy: missing" in capsys.readouterr().err


def test_a_fine_tuning_has_no_weights_of_its_own(project, capsys):
    project(("rows", "FC-498", "start"), {"bisenet": {"weights": "start.safetensors"}})
    assert train() == 1
    assert "rows.FC-498: starts from the baseline" in capsys.readouterr().err
