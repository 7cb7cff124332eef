"""The chain on the smallest params, run once by each engine for all tests that look at what it made."""

from pathlib import Path

import pytest
from engines import clone, for_dvc, run


@pytest.fixture(scope="session")
def snakemake(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A clone, in a folder with spaces and quotes, in which Snakemake ran the chain on two cores."""
    folder = clone(tmp_path_factory.mktemp("it's a clone"))
    run(folder, "snakemake", "--cores", "2", "--configfile", "params/smoke.yaml")
    return folder


@pytest.fixture(scope="session")
def dvc(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A clone in which DVC ran the chain, elsewhere: in another time zone, language and order of hashes."""
    folder = for_dvc(clone(tmp_path_factory.mktemp("clone of another user")))
    elsewhere = {"TZ": "Pacific/Chatham", "LANG": "C", "LC_ALL": "C", "PYTHONHASHSEED": "4"}
    run(folder, "dvc", "repro", changes=elsewhere)
    return folder
