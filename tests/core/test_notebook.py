"""The notebook: its cells run, and say what it shows."""

import importlib.util
import json
from pathlib import Path

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
LARGEST = 100_000  # bytes: what a reader of the repository has to load


def make_notebook():
    spec = importlib.util.spec_from_file_location("make_notebook", EXAMPLES / "make_notebook.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_notebook_says_what_its_cells_print_and_is_small(capsys) -> None:
    assert make_notebook().main(["--check"]) == 0, capsys.readouterr().out
    path = EXAMPLES / "fog_and_scores.ipynb"
    assert path.stat().st_size < LARGEST
    kinds = [
        output["output_type"] for cell in json.loads(path.read_text())["cells"] for output in cell.get("outputs", [])
    ]
    assert kinds.count("display_data") == 2


def test_a_notebook_that_is_not_as_it_runs_is_found(tmp_path: Path, capsys) -> None:
    cell = {"cell_type": "code", "source": ["1 + 1"], "outputs": [], "execution_count": None}
    (tmp_path / "old.ipynb").write_text(json.dumps({"cells": [cell]}))
    assert make_notebook().main(["--check", str(tmp_path / "old.ipynb")]) == 1
    assert make_notebook().main([str(tmp_path / "old.ipynb")]) == 0
    assert make_notebook().main(["--check", str(tmp_path / "old.ipynb")]) == 0
    assert json.loads((tmp_path / "old.ipynb").read_text())["cells"][0]["outputs"][0]["data"] == {"text/plain": ["2"]}
