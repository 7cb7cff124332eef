"""figures of scores: drawn from metrics alone, the same bytes each time, and clear where a run is missing."""

import json
from pathlib import Path

import numpy as np
import pytest
from records import vouch

from foggy_synscapes.cli import main
from foggy_synscapes.figures.sky_contrast import cut_histogram
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.plain_yaml import read_yaml
from foggy_synscapes.io.tables import write_csv
from foggy_synscapes.scoring.metrics import summarize

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def scored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Metrics of three rows of both networks on Foggy Zurich, without the class train."""
    monkeypatch.chdir(tmp_path)
    write_text(Path("params.yaml"), json.dumps(read_yaml(ROOT / "params.yaml")))
    rng = np.random.default_rng(0)
    for network in ("refinenet", "bisenet"):
        for row in ("C", "FC-498", "FS-498"):
            matrix = rng.integers(0, 100, (19, 20))
            matrix[16] = 0
            path = Path(f"results/evaluate/foggy_zurich/{network}/{row}/seed-0/metrics.json")
            write_text(path, json.dumps(summarize(matrix, images=24)))
    vouch()


@pytest.mark.parametrize("kind", ["class_change", "confusion"])
def test_figures_of_scores_need_metrics_only(scored, kind):
    name, made = f"{kind}_foggy_zurich", []
    for _ in range(2):
        assert main(["figures", "--figure", name]) == 0
        made.append([Path(f"results/figures/{name}.{ending}").read_bytes() for ending in ("png", "pdf", "run.json")])
    assert made[0] == made[1]
    record = json.loads(made[0][2])
    assert len(record["inputs"]) == 6
    assert all(path.endswith("metrics.json") for path in record["inputs"])


def test_change_needs_the_baseline(scored, capsys):
    Path("results/evaluate/foggy_zurich/bisenet/C/seed-0/metrics.json").unlink()
    assert main(["figures", "--figure", "class_change_foggy_zurich"]) == 1
    assert "no scores of row C of bisenet on foggy_zurich" in capsys.readouterr().err


@pytest.mark.parametrize("kind", ["class_change", "confusion"])
def test_a_set_without_any_scores_is_an_error(scored, capsys, kind):
    assert main(["figures", "--figure", f"{kind}_foggy_driving"]) == 1
    assert "no scores of refinenet on foggy_driving" in capsys.readouterr().err
    assert not Path("results/figures").exists()


def filtered(values: list[float], kept: list[int]) -> bytes:
    """Draw the figure of frames with these values of sky contrast."""
    rows = [(n, *each) for n, each in enumerate(zip(values, kept, strict=True), start=1)]
    write_csv("results/filter/frames.csv", ("id", "sky_contrast", "kept"), rows)
    vouch()
    assert main(["figures", "--figure", "sky_contrast"]) == 0
    return Path("results/figures/sky_contrast.png").read_bytes()


def test_the_histogram_of_sky_contrast_shows_what_the_filter_leaves_out(scored):
    first = filtered([2.0, 3.0, 5.5], [1, 1, 0])
    assert filtered([2.0, 3.0, 5.5], [1, 1, 0]) == first
    assert filtered([2.0, 3.0, 5.5], [1, 0, 0]) != first
    assert json.loads(Path("results/figures/sky_contrast.run.json").read_text())["inputs"].keys() == {
        "results/filter/frames.csv"
    }


def test_one_value_in_all_frames_still_makes_a_histogram():
    figure = cut_histogram([3.0, 3.0], [True, True], [], "sky_contrast")
    assert sum(patch.get_height() for patch in figure.axes[0].patches) == 2


def test_no_bin_of_the_histogram_lies_across_the_cut():
    figure = cut_histogram([2.0, 4.99, 5.01, 6.0], [True, True, False, False], [("maximum", 5.0)], "sky_contrast")
    spans = [(patch.get_x(), patch.get_x() + patch.get_width()) for patch in figure.axes[0].patches]
    assert not [span for span in spans if span[0] < 5 - 1e-9 and span[1] > 5 + 1e-9]
