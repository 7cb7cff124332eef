"""`torchrun ... -m foggy_synscapes train`: the same files from several processes, and one message where it fails."""

import csv
import json
import subprocess
import sys
from pathlib import Path

import processes
import pytest
from training_project import hashes, project_in, train

FOLDER = Path("results/train/refinenet/C/seed-0")


@pytest.fixture
def project(tmp_path, monkeypatch):
    """A project to train in; gives a function that changes its params."""
    return project_in(tmp_path, monkeypatch)


def by_torchrun():
    call = [sys.executable, "-m", "torch.distributed.run", "--nproc-per-node", "2", "-m", "foggy_synscapes"]
    call += ["train", "--network", "refinenet", "--row", "C", "--seed", "0"]
    subprocess.run(call, check=True, timeout=300)


def losses():
    with open(FOLDER / "curves.csv", newline="") as file:
        return [float(row["train_loss"]) for row in csv.DictReader(file)]


def test_two_processes_train_what_one_does(project, capfd):
    project(("refinenet", "baseline", "freeze_batch_norm"), True)
    assert train("refinenet") == 0
    alone = losses()
    assert json.loads((FOLDER / "run.json").read_text())["processes"] == 1
    for name in hashes("refinenet"):
        (FOLDER / name).unlink()

    capfd.readouterr()
    by_torchrun()
    assert capfd.readouterr().out.count("(kept)") == 1
    assert list(hashes("refinenet")) == ["curves.csv", "model.safetensors", "run.json"]
    assert losses() == pytest.approx(alone, rel=1e-5)
    assert json.loads((FOLDER / "run.json").read_text())["processes"] == 2


@pytest.mark.parametrize("missing", ["image_1.png", "image_5.png"], ids=["of training", "of validation"])
def test_a_missing_file_ends_both_processes_with_one_message(project, capfd, missing):
    Path("results/scenes/cityscapes", missing).unlink()
    found = processes.started(2, train, "refinenet")
    assert [found.count(1), sum(isinstance(each, SystemExit) and each.code == 1 for each in found)] == [1, 1]
    assert [missing in line for line in capfd.readouterr().err.splitlines()] == [True]
    assert not FOLDER.exists()


def test_a_batch_that_two_processes_cannot_share_is_refused(project, capfd):
    project(("refinenet", "baseline", "batch"), 3)
    processes.started(2, train, "refinenet")
    message = capfd.readouterr().err
    assert len([line for line in message.splitlines() if not line.startswith("train ")]) == 1
    assert "refinenet C: batch: 3 images in 1 passes (accumulate) cannot be shared evenly by 2 processes" in message
