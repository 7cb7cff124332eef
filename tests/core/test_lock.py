"""One engine at a time in a folder, and none locked out by a run that was killed."""

import subprocess
import sys
from pathlib import Path

import pytest

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io import lock

HOLD = "from foggy_synscapes.io import lock; held = lock.hold(); print('held', flush=True); input()"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv(lock.HELD, raising=False)
    return tmp_path


def test_a_second_engine_and_a_job_of_another_are_refused_until_the_first_is_killed(here: Path) -> None:
    first = subprocess.Popen([sys.executable, "-c", HOLD], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert first.stdout.readline() == b"held\n"
    assert not lock.is_free()
    for take in (lock.hold, lock.join):
        with pytest.raises(FoggyError, match="another run is at work in this folder"):
            take()
    first.kill()
    first.communicate()
    assert lock.is_free()
    lock.hold().close()


def test_jobs_do_not_keep_each_other_out_but_an_engine(here: Path) -> None:
    lock.hold().close()
    jobs = [lock.join(), lock.join()]
    with pytest.raises(FoggyError, match="another run"):
        lock.hold()
    for job in jobs:
        job.close()
    assert lock.is_free()


def test_a_folder_that_cannot_be_written_to_is_said(here: Path) -> None:
    Path(".foggy").write_text("a file where the folder must be")
    for take in (lock.hold, lock.join):
        with pytest.raises(FoggyError, match=r"^\.foggy/lock: cannot be opened: File exists"):
            take()


def test_a_job_leaves_the_lock_to_the_engine_that_started_it(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with lock.hold():
        monkeypatch.setenv(lock.HELD, "snakemake")
        lock.join().close()


def test_a_new_engine_waits_for_jobs_whose_engine_was_killed(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The job holds no lock of its own but this: its engine held the other one, and is gone."""
    monkeypatch.setenv(lock.HELD, "snakemake")
    job = lock.join()
    assert lock.is_free()
    next_one = subprocess.Popen([sys.executable, "-c", HOLD], stdin=-1, stdout=-1, stderr=subprocess.STDOUT)
    assert next_one.stdout.readline() == b"waiting for the end of jobs whose engine was killed\n"
    job.close()
    assert next_one.stdout.readline() == b"held\n"
    next_one.communicate(b"\n")
