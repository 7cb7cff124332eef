"""DVC after a kill: half of a file that it writes in place is removed, and what was made is not made again."""

import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest
from dvc.repo import Repo
from engines import ROOT, clone, environment, for_dvc, hashes, own_sources, ran

from foggy_synscapes.io.lock import HELD
from foggy_synscapes.provenance.runs import PLANNED

sys.path.append(str(ROOT / "workflow"))
from repro import main, repair

LOCK = b"""\
schema: '2.0'
stages:
  filter:
    cmd: foggy filter
    deps:
    - path: results/scenes/index.csv
      hash: md5
      md5: b026324c6904b2a9cb4b88d6d61c81d1
      size: 2
  fog@0.005:
    cmd: foggy fog --beta 0.005
    outs:
    - path: results/fog/0000.tar
      hash: md5
      md5: 26ab0db90d72e28ad0ba1e22ee510510
      size: 2
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A clone in which nothing ran yet."""
    folder = for_dvc(clone(tmp_path / "clone"))
    monkeypatch.chdir(folder)
    for name in (PLANNED, HELD):  # `main` sets them for its jobs
        monkeypatch.setenv(name, "")
        monkeypatch.delenv(name)
    return folder


@pytest.mark.parametrize("torn", [b"", b"schema: '2.0'\nsta", LOCK[:-30] + b"\n  bro"])
def test_a_torn_lock_file_is_removed_and_a_whole_one_kept(folder: Path, torn: bytes) -> None:
    Path("dvc.lock").write_bytes(torn)
    assert repair(Repo()) == ["dvc.lock"]
    assert not Path("dvc.lock").exists()
    Path("dvc.lock").write_bytes(LOCK)
    assert repair(Repo()) == []
    assert Path("dvc.lock").read_bytes() == LOCK


@pytest.mark.parametrize("torn", ["", "[]", '{"write": {"resu', '{"write": 3}'])
def test_a_torn_note_of_readers_is_removed_also_from_a_folder_below(folder: Path, torn: str, monkeypatch) -> None:
    note = Path(Repo().tmp_dir, "rwlock")
    note.write_text(torn)
    monkeypatch.chdir("workflow")
    assert repair(Repo()) == [".dvc/tmp/rwlock"]
    assert not note.exists()
    note.write_text("{}")
    assert repair(Repo()) == []


def test_what_stops_it_is_one_line(folder: Path, capsys: pytest.CaptureFixture) -> None:
    with Repo().lock:
        assert main([]) == 1
    told = capsys.readouterr().err
    assert told.startswith("repro: Unable to acquire lock")
    assert "Traceback" not in told


JOB = """
import time
from pathlib import Path
from foggy_synscapes.io import lock
held = lock.join()
Path("begun").touch()
while not Path("may end").exists():
    time.sleep(0.05)
Path("made").touch()
"""


def test_a_job_that_outlives_its_dvc_is_waited_for(folder: Path) -> None:
    Path("job.py").write_text(JOB)
    Path("dvc.yaml").write_text("stages:\n  job:\n    cmd: python job.py\n    deps: [job.py]\n    outs: [made]\n")
    call = [sys.executable, "workflow/repro.py"]
    first = subprocess.Popen(call, env=environment(), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        while not Path("begun").exists():
            assert first.poll() is None
            time.sleep(0.05)
        first.kill()  # DVC alone
        first.wait()
        second = subprocess.Popen(call, env=environment(), stdout=-3, stderr=subprocess.PIPE, text=True)
        assert second.stderr.readline() == "waiting for the end of jobs whose engine was killed\n"
    finally:
        Path("may end").touch()
    assert "Traceback" not in second.communicate()[1]
    assert second.returncode == 0


def test_torn_files_of_dvc_are_removed_and_only_raw_files_are_listed_again(dvc: Path, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(dvc, tmp_path / "clone", symlinks=True))
    before, lock = hashes(folder), (folder / "dvc.lock").read_bytes()
    # Inside a key; where a value is cut, DVC reads on and takes that step for changed.
    (folder / "dvc.lock").write_bytes(lock[: lock.rindex(b"- path") + 4])
    (folder / ".dvc/tmp/rwlock").write_text('{"write": {"resu')
    call = [sys.executable, "workflow/repro.py"]
    told = subprocess.run(
        call, cwd=folder, env=environment(own_sources(folder)), capture_output=True, text=True, check=False
    )
    assert told.returncode == 0, told.stdout + told.stderr
    assert "dvc.lock was torn by a kill" in told.stderr
    assert ".dvc/tmp/rwlock was torn by a kill" in told.stderr
    # Without dvc.lock DVC would take lists of raw files from its cache, whatever the files are now: they are made anew.
    assert {name.partition(" ")[0] for name in ran(told.stdout + told.stderr)} <= {"code", "scenes"}
    assert hashes(folder) == before
    assert (folder / "dvc.lock").read_bytes() == lock
