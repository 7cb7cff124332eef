"""The chain on the smallest params, run once by each engine for all tests that look at what it made."""

import fcntl
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
import warm
from engines import clone, for_dvc, run


@pytest.fixture(scope="session")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, Callable[[Path], None]], Path]:
    """Make a folder by the first worker that asks for it; each worker gets a copy of its own, which it may change."""
    own = tmp_path_factory.getbasetemp()
    common = own.parent if own.name.startswith("popen-") else own

    def folder(name: str, make: Callable[[Path], None]) -> Path:
        made, done = common / name, common / f"{name} is done"
        with (common / f"{name} lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not done.exists():
                make(clone(made))
                done.touch()
        return Path(shutil.copytree(made, tmp_path_factory.mktemp("chain") / name, symlinks=True))

    return folder


@pytest.fixture(scope="session")
def snakemake(shared) -> Path:
    """A clone, in a folder with spaces and quotes, in which Snakemake ran the chain on two cores."""
    smoke = ("--cores", "2", "--configfile", "params/smoke.yaml")
    return shared("it's a clone", lambda folder: run(folder, "snakemake", *smoke))


@pytest.fixture(scope="session")
def dvc(shared, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A clone in which DVC ran the chain, elsewhere: in another time zone, language and order of hashes."""
    elsewhere = {"TZ": "Pacific/Chatham", "LANG": "C", "LC_ALL": "C", "PYTHONHASHSEED": "4"}

    def make(folder: Path) -> None:
        with warm.jobs(tmp_path_factory.mktemp("warm") / "jobs", elsewhere) as changes:
            run(for_dvc(folder), "dvc", "repro", changes=changes)

    return shared("clone of another user", make)
