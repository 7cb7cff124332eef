"""Through both engines: names and values of a params file are data, and no shell line comes of them."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml
from engines import clone, complete, for_dvc, run

from foggy_synscapes.datasets import foggy_zurich
from foggy_synscapes.io.atomic import write_bytes, write_text
from foggy_synscapes.io.images import encode_png
from foggy_synscapes.io.tables import read_csv

ODD = 'it\'s a "root"; touch gone; $(touch gone) `touch gone`\n{wildcards.x} & *'
INDEX = "results/scenes/index/foggy_zurich/all.csv"


@pytest.fixture
def folder(tmp_path: Path):
    """A clone with params of the smoke case; afterwards nothing may have been touched."""
    yield clone(tmp_path / "clone")
    assert not list(tmp_path.rglob("gone*"))


def zurich(root: Path) -> None:
    """One frame of the layout of Foggy Zurich."""
    frame = "GP/1.0_frame_1"
    write_bytes(root / foggy_zurich.image(frame), encode_png(np.zeros((8, 8, 3), np.uint8)))
    write_bytes(root / foggy_zurich.labels(frame), encode_png(np.zeros((8, 8), np.uint8)))
    for kind, path in (("RGB", foggy_zurich.image(frame)), ("gt_labelIds", foggy_zurich.labels(frame))):
        write_text(root / foggy_zurich.list_path(kind), f"{path}\n")


def changed(folder: Path, file: str, **sections: dict) -> None:
    """Params of the smoke case with some values changed, as `file`."""
    document = yaml.safe_load(complete(folder / "params/smoke.yaml"))
    for section, values in sections.items():
        for key, value in values.items():
            document[section][key] = {**document[section][key], **value} if isinstance(value, dict) else value
    write_text(folder / file, yaml.safe_dump(document, sort_keys=False))


def test_odd_names_of_a_dataset_and_of_a_params_file_reach_no_shell(folder: Path) -> None:
    root = folder.parent / ODD.replace("/", "")
    zurich(root)
    name = "my params'; touch gone; $(touch gone) {x}.yaml"
    changed(folder, name, scenes={"roots": {"foggy_zurich": f"{folder}/../{root.name}"}})
    run(folder, "snakemake", INDEX, "--cores", "1", "--configfile", name)
    assert len(read_csv(folder / INDEX)) == 4
    assert all(not path.startswith("/") for path in (row["path"] for row in read_csv(folder / INDEX)))
    assert str(folder) not in (folder / INDEX).with_name("run.json").read_text()


def test_a_beta_with_a_command_in_it_stops_both_engines_before_any_job(folder: Path) -> None:
    changed(folder, "params.yaml", fog={"betas": ["0.005; touch gone"]})

    for call in (["-m", "snakemake", "--cores", "1"], ["-m", "dvc", "repro"], ["workflow/repro.py"]):
        subprocess.run(["git", "init", "--quiet"], cwd=folder, check=True)
        result = subprocess.run([sys.executable, *call], cwd=folder, capture_output=True, text=True, check=False)
        told = result.stdout + result.stderr
        assert result.returncode != 0
        assert "beta" in told
        assert "is not a number" in told
    assert not (folder / "results/scenes/index").exists()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("a: &a [x]\nb: &b [*a, *a]\nc: [*b, *b]\n", "aliases are not allowed"),
        ("fog: !!python/object/apply:os.system [touch gone]\n", "could not determine a constructor for the tag"),
    ],
)
def test_yaml_that_grows_or_runs_is_refused_before_dvc_reads_it(folder: Path, text: str, told: str) -> None:
    for_dvc(folder)
    write_text(folder / "params.yaml", text)
    call = [sys.executable, "workflow/repro.py"]
    result = subprocess.run(call, cwd=folder, capture_output=True, text=True, check=False)
    assert result.returncode == 1
    assert result.stderr.startswith("repro: params.yaml")
    assert told in result.stderr
    assert "Traceback" not in result.stderr
