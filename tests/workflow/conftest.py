"""The chain on the smallest params, run once by each engine for all tests that look at what it made."""

import shutil
import subprocess
from pathlib import Path

import pytest
from engines import clone, run


@pytest.fixture(scope="session")
def snakemake(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A clone, in a folder with spaces and quotes, in which Snakemake ran the chain on two cores."""
    folder = clone(tmp_path_factory.mktemp("it's a clone"))
    run(folder, "snakemake", "--cores", "2", "--configfile", "params/smoke.yaml")
    return folder


@pytest.fixture(scope="session")
def dvc(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A clone in which DVC ran the chain."""
    folder = clone(tmp_path_factory.mktemp("clone"))
    shutil.copy(folder / "params/smoke.yaml", folder / "params.yaml")
    subprocess.run(["git", "init", "--quiet"], cwd=folder, check=True)
    run(folder, "dvc", "repro")
    return folder
