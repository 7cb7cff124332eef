"""What `make gpu-check` does: all of it where there is a GPU, and a word where there is none."""

import sys
from pathlib import Path

import gpu
import pytest
import torch

ROOT = Path(__file__).resolve().parents[2]
NONE = f"PyTorch {torch.__version__} finds no GPU"


def test_where_there_is_no_gpu_it_says_so_and_ends_well(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture, tmp_path: Path
) -> None:
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    monkeypatch.setattr(sys, "argv", ["gpu.py", "--out", str(tmp_path / "page.md")])
    assert gpu.main() == 0
    assert "gpu-check: skipped" in capsys.readouterr().out
    assert not (tmp_path / "page.md").exists()


def test_the_readme_says_whether_it_ever_ran() -> None:
    readme = (ROOT / "README.md").read_text()
    assert ("never run on a GPU" in readme) is not (ROOT / "docs/gpu.md").exists()


@pytest.mark.skipif(not torch.cuda.is_available(), reason=NONE)
@pytest.mark.parametrize("name", ["bisenet", "refinenet"])
def test_float32_on_a_gpu_is_near_the_cpu_and_a_step_waits_once(name: str) -> None:
    rows, near = gpu.measure(name, "cuda", workers=4)
    assert near
    assert {int(row[5]) for row in rows} <= {0, 1}


@pytest.mark.skipif(not torch.cuda.is_available(), reason=NONE)
def test_the_smoke_chain_repeats_on_a_gpu_also_after_a_kill() -> None:
    said = gpu.chain("cuda")
    assert [" 0 different" in line for line in said] == [True, True]
