"""tradeoff of fog: each variant against the reference, the Pareto front, and words that follow from figures."""

from pathlib import Path

import numpy as np
import pytest
from fog_frames import CAMERA, content, write_frames
from records import index_of, vouch

from foggy_synscapes.datasets import synscapes
from foggy_synscapes.datasets.index import write_index
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.fog.airlight import estimate
from foggy_synscapes.io.plain_yaml import read_yaml
from foggy_synscapes.io.tables import read_csv, write_csv
from foggy_synscapes.params import Params, check
from foggy_synscapes.stages.tradeoff import tradeoff
from foggy_synscapes.tradeoff.fog import Score, measure, paragraph, pareto_front
from foggy_synscapes.tradeoff.fog_variants import Variant, variants

ROOT = Path(__file__).resolve().parents[2]
BETAS = [0.005, 0.01, 0.02, 0.03, 0.06]


def score(name: str, cpu_ms: float, mean: float) -> Score:
    return Score(Variant(name, "", lambda *rest: np.zeros(0)), cpu_ms, 100 * mean, int(mean > 0), mean)


@pytest.fixture(scope="module")
def scores() -> dict[str, Score]:
    frames = [(*content(frame), CAMERA) for frame in range(1, 13)]
    return {one.variant.name: one for one in measure(frames, BETAS, repeats=1)}


@pytest.mark.parametrize("name", ["float64", "shared powers", "compiled"])
def test_some_variants_change_nothing(scores: dict[str, Score], name: str) -> None:
    assert (scores[name].changed, scores[name].largest, scores[name].mean) == (0, 0, 0)


@pytest.mark.parametrize(
    ("name", "least", "most", "largest"),
    [
        ("float32", 0, 0.01, 1),
        ("t in 16 bits", 0, 0.5, 1),
        ("half depth", 0.01, 5, 1),
        ("float16", 1, 15, 1),
        ("t in 8 bits", 2, 40, 1),
        ("bfloat16", 20, 80, 8),
    ],
)
def test_coarser_numbers_change_more(
    scores: dict[str, Score], name: str, least: float, most: float, largest: int
) -> None:
    assert least <= scores[name].changed <= most
    assert scores[name].largest <= largest


def test_another_geometry_changes_little_and_planar_depth_much(scores: dict[str, Score]) -> None:
    assert 0 < scores["exact geometry"].mean < scores["planar depth"].mean


def test_emulated_arithmetic_has_no_time(scores: dict[str, Score]) -> None:
    assert np.isnan(scores["bfloat16"].cpu_ms)
    assert all(one.cpu_ms > 0 for name, one in scores.items() if name != "bfloat16")


def test_betas_that_are_no_multiples_are_not_taken_for_powers() -> None:
    image, depth = content(1)
    light, betas = estimate(image).levels, [0.0071, 0.02, 0.0355]
    plain, shared = (way.way(image, depth, CAMERA, light, betas) for way in variants()[:2])
    np.testing.assert_array_equal(plain, shared)


def test_the_front_holds_what_nothing_beats() -> None:
    scores = [
        score("exact", 10, 0), score("slower", 30, 0), score("rough", 5, 0.1), score("worse", 6, 0.2),
        score("as fast but rough", 9.9, 0.05), score("emulated", np.nan, 0.01),
    ]  # fmt: skip
    assert pareto_front(scores) == ["exact", "rough"]


def test_the_paragraph_says_what_the_figures_say() -> None:
    plain, ours, rough = score("float64", 50, 0), score("compiled", 5, 0), score("rough", 2, 0.1)
    text = paragraph([plain, ours, rough], "2 betas")
    assert "default is **compiled**, 5.0 ms of CPU time per image, 10 times faster than float64 (50 ms)" in text
    assert "Of the variants that change no sample it is the fastest." in text
    assert "rough would take 2.0 ms and change 10 % of the samples, by up to 1." in text
    text = paragraph([plain, score("compiled", 80, 0.01)], "2 betas")
    assert "changes 1 % of the samples; the fastest without a change is float64" in text


@pytest.fixture
def params(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Params:
    monkeypatch.chdir(tmp_path)
    write_frames(Path("synscapes"), 2)
    write_index(
        index_of("synscapes", "0000"),
        Path("synscapes"),
        [path(n) for n in (1, 2) for path in (synscapes.rgb, synscapes.depth)],
    )
    write_csv("results/filter/kept.csv", ("id", *vars(CAMERA)), [(n, *vars(CAMERA).values()) for n in (1, 2)])
    vouch()
    document = read_yaml(ROOT / "params.yaml")
    document["scenes"]["roots"]["synscapes"] = "synscapes"
    document["scenes"]["shards"] = ["0000"]
    document["tradeoff"] |= {"frames": 2, "repeats": 1}
    return check(document, "params.yaml")


def test_table_plot_and_text_are_written(params: Params) -> None:
    tradeoff(params, "fog")
    rows = read_csv("results/tradeoff/fog.csv")
    assert [row["variant"] for row in rows] == [variant.name for variant in variants()]
    assert {row["cpu_ms"] for row in rows if row["variant"] == "bfloat16"} == {"--"}
    assert "longtable" in Path("results/tradeoff/fog.tex").read_text()
    assert "the default is **compiled**" in Path("results/tradeoff/fog.md").read_text()
    assert Path("results/tradeoff/fog.png").read_bytes().startswith(b"\x89PNG")
    assert Path("results/tradeoff/fog.pdf").read_bytes().startswith(b"%PDF")
    assert Path("results/tradeoff/fog.run.json").is_file()


def test_more_frames_than_were_kept_are_refused(params: Params) -> None:
    more = params.model_copy(update={"tradeoff": params.tradeoff.model_copy(update={"frames": 3})})
    with pytest.raises(FoggyError, match=r"tradeoff\.frames: asks for 3 frames, but the filter kept 2"):
        tradeoff(more, "fog")
