"""Figures show what their files say: panels, axes, legends, and the data of lines, bars and images."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from fog_frames import CAMERA, content

from foggy_synscapes.figures import FIGURES
from foggy_synscapes.figures.errors import LOWEST, errors
from foggy_synscapes.figures.panels import colour
from foggy_synscapes.figures.pareto import NONE, accuracy_front, errors_front
from foggy_synscapes.figures.sources import Frame, Sample, Sources
from foggy_synscapes.fog.airlight import estimate
from foggy_synscapes.fog.geometry import rays
from foggy_synscapes.fog.optics import foggy_images
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.labels import CLASSES
from foggy_synscapes.params import Params, load
from foggy_synscapes.scoring.metrics import summarize
from foggy_synscapes.steps import job

ROOT = Path(__file__).resolve().parents[2]
TITLES = {"refinenet": "RefineNet", "bisenet": "BiSeNet"}
ABSENT = 16


@pytest.fixture
def params(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Params:
    monkeypatch.chdir(tmp_path)
    return load(ROOT / "params.yaml")


def drawn(params: Params, name: str, **values: str):
    """The figure, from the files of its job."""
    return FIGURES[name].draw(Sources(job(params, f"figures_{name}", **values), {}))


def texts(labels) -> list[str]:
    return [label.get_text() for label in labels]


def legend(figure) -> list[str]:
    return texts(figure.legends[0].get_texts())


@pytest.fixture
def scored(params: Params) -> dict[tuple[str, str], dict]:
    """Metrics of three rows of both networks on Foggy Zurich, without the class train, as they lie in their files."""
    rng = np.random.default_rng(0)
    for network in TITLES:
        for row in ("C", "FC-498", "FS-498"):
            matrix = rng.integers(0, 100, (19, 20))
            matrix[ABSENT] = 0
            write_text(metrics_of(network, row), json.dumps(summarize(matrix, images=24)))
    return {
        (network, row): json.loads(metrics_of(network, row).read_text())
        for network in TITLES
        for row in ("C", "FC-498", "FS-498")
    }


def metrics_of(network: str, row: str) -> Path:
    return Path(f"results/evaluate/foggy_zurich/{network}/{row}/seed-0/metrics.json")


def test_class_change_shows_the_difference_of_each_class_to_the_baseline(params: Params, scored: dict) -> None:
    figure = drawn(params, "class_change", test_set="foggy_zurich")
    assert [panel.get_title() for panel in figure.axes] == list(TITLES.values())
    assert legend(figure) == ["FC-498", "FS-498"]
    assert texts(figure.axes[0].get_yticklabels()) == [*CLASSES, "mean (18 annotated)"]  # of both panels
    for panel, network in zip(figure.axes, TITLES, strict=True):
        assert panel.get_xlabel() == "change of IoU against C (points)"
        marks = {line.get_label(): line for line in panel.lines if not line.get_label().startswith("_")}
        for row, line in marks.items():
            own, plain = scored[network, row], scored[network, "C"]
            expected = [
                one["iou"] - other["iou"]
                for one, other in zip(own["classes"], plain["classes"], strict=True)
                if one["iou"] is not None
            ]
            expected.append(own["mean_iou"]["annotated"] - plain["mean_iou"]["annotated"])
            np.testing.assert_array_equal(line.get_xdata(), expected)
            assert len(expected) == 19
            assert not np.isclose(line.get_ydata(), ABSENT, atol=0.5).any()


def test_confusion_shows_the_shares_of_the_best_row(params: Params, scored: dict) -> None:
    figure = drawn(params, "confusion", test_set="foggy_zurich")
    *panels, bar = figure.axes
    assert bar.get_ylabel() == "share of the labelled pixels (%)"
    assert texts(panels[0].get_yticklabels()) == list(CLASSES)
    for panel, (network, title) in zip(panels, TITLES.items(), strict=True):
        means = {row: scored[network, row]["mean_iou"]["annotated"] for row in ("C", "FC-498", "FS-498")}
        best = max(means, key=means.__getitem__)
        assert panel.get_title() == f"{title}, {best} (highest mean IoU)"
        assert texts(panel.get_xticklabels()) == [*CLASSES, "no class"]
        own = scored[network, best]
        matrix = np.column_stack([own["confusion"], own["unlabelled_predictions"]]).astype(float)
        with np.errstate(invalid="ignore"):
            shares = 100 * matrix / matrix.sum(axis=1, keepdims=True)
        np.testing.assert_allclose(np.ma.filled(panel.images[0].get_array(), np.nan), shares)
        written = [int(text.get_text()) for text in panel.texts]
        assert written == [round(share) for share in shares.ravel() if share >= 5]


def test_curves_are_those_of_the_files_with_a_dot_at_the_lowest_validation_loss(params: Params) -> None:
    rows, rng, tables = Sources(job(params, "figures_curves"), {}).rows, np.random.default_rng(1), {}
    for network in TITLES:
        for row in rows:
            table = pd.DataFrame({"step": [10, 20, 40], "train_loss": rng.uniform(0.5, 3, 3)})
            table["validation_loss"] = [rng.uniform(0.5, 3), np.nan, rng.uniform(0.5, 3)]
            path = Path(f"results/train/{network}/{row}/seed-0/curves.csv")
            write_text(path, table.to_csv(index=False))
            tables[network, row] = pd.read_csv(path)
    figure = drawn(params, "curves")
    assert len(figure.axes) == 2 * len(TITLES)
    assert legend(figure) == rows
    above, below = np.reshape(figure.axes, (2, len(TITLES)))
    assert [panel.get_ylabel() for panel in (above[0], below[0])] == ["training loss", "validation loss"]
    for training, validation, (network, title) in zip(above, below, TITLES.items(), strict=True):
        assert training.get_title() == title
        assert {training.get_yscale(), validation.get_yscale()} == {"log"}
        dots = [line.get_xydata()[0].tolist() for line in validation.lines if line.get_marker() == "o"]
        assert len(dots) == len(rows)
        for panel, name in ((training, "train_loss"), (validation, "validation_loss")):
            lines = {line.get_label(): line.get_xydata() for line in panel.lines if line.get_marker() != "o"}
            for row in rows:
                table = tables[network, row].dropna(subset=name)
                np.testing.assert_allclose(lines[row], np.column_stack([table["step"] * 2.5, table[name]]))
        for row, dot in zip(rows, dots, strict=True):
            best = tables[network, row].sort_values("validation_loss").iloc[0]
            assert dot == [best["step"] * 2.5, best["validation_loss"]]


def test_bars_of_sky_contrast_count_the_frames_of_the_filter(params: Params) -> None:
    rng = np.random.default_rng(2)
    table = pd.DataFrame({"sky_contrast": rng.uniform(0, 6, 200).round(3), "kept": rng.integers(0, 2, 200)})
    write_text("results/filter/frames.csv", table.to_csv(index=False))
    cut = params.filter.rules[0].model_copy(update={"key": "sky_contrast", "minimum": None, "maximum": 5.0})
    narrowed = params.model_copy(update={"filter": params.filter.model_copy(update={"rules": [cut]})})
    figure = drawn(narrowed, "sky_contrast")
    (panel,) = figure.axes
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("sky_contrast", "frames")
    kept, left_out = (list(bars) for bars in panel.containers)
    for bars, values in ((kept, table.query("kept == 1")), (left_out, table.query("kept == 0"))):
        edges = [bar.get_x() for bar in bars] + [bars[-1].get_x() + bars[-1].get_width()]
        counts, _ = np.histogram(values["sky_contrast"], edges)
        np.testing.assert_array_equal([bar.get_height() for bar in bars], counts)
        assert counts.sum() == len(values)
    np.testing.assert_array_equal([bar.get_y() for bar in left_out], [bar.get_height() for bar in kept])
    assert [line.get_xdata()[0] for line in panel.lines] == [5.0]
    share = table["kept"].sum()
    expected = [f"kept: {share} frames", f"left out: {200 - share} frames", "maximum of the filter: 5"]
    assert sorted(legend(figure)) == sorted(expected)


def frames(count: int) -> list[Frame]:
    return [Frame(number, *content(number), CAMERA) for number in range(1, count + 1)]


def fog_on(frame: Frame, betas: list[str]) -> np.ndarray:
    light = estimate(frame.clear).levels
    return foggy_images(frame.clear, frame.depth, rays(frame.camera), light, [float(beta) for beta in betas])


def panels_of(figure, columns: int) -> np.ndarray:
    return np.reshape(np.array(figure.axes, dtype=object), (-1, columns))


def test_the_beta_strip_shows_each_frame_clear_and_at_each_beta(params: Params) -> None:
    sources = SimpleNamespace(params=params, frames=frames)
    figure, betas = FIGURES["beta_strip"].draw(sources), params.figures.betas
    panels = panels_of(figure, 1 + len(betas))
    assert [panel.get_title() for panel in panels[0]][:2] == ["clear", "β = 0.005 / m, visibility 599 m"]
    for line, frame in zip(panels, frames(2), strict=True):
        shown = [panel.images[0].get_array() for panel in line]
        np.testing.assert_array_equal(shown, [frame.clear, *fog_on(frame, betas)])


def test_synscapes_stands_above_cityscapes_at_the_same_beta(params: Params) -> None:
    below = [np.full((8, 16, 3), level, np.uint8) for level in (10, 200, 90)]
    sources = SimpleNamespace(params=params, frames=frames, refined=lambda beta, count: below[:count])
    figure, beta = FIGURES["fc_against_fs"].draw(sources), params.figures.comparison_beta
    panels = panels_of(figure, 3)  # as many as both have
    assert [panel.get_ylabel() for panel in panels[:, 0]] == ["Foggy Synscapes", "Foggy Cityscapes"]
    assert f"β = {beta} / m" in figure.get_suptitle()
    for (above, under), frame, image in zip(panels.T, frames(3), below, strict=True):
        np.testing.assert_array_equal(above.images[0].get_array(), fog_on(frame, [beta])[0])
        np.testing.assert_array_equal(under.images[0].get_array(), image)


def test_predictions_stand_beside_the_truth_with_their_score(params: Params) -> None:
    truth = np.zeros((4, 4), np.uint8)
    guess = {"C": truth.copy(), "FS-498": np.where(np.arange(4) < 2, truth, 1).astype(np.uint8)}
    image = np.full((4, 4, 3), 7, np.uint8)
    sources = SimpleNamespace(
        params=params, networks={"bisenet": "BiSeNet"}, rows=list(guess), title=lambda: "Foggy Zurich",
        images=lambda count: [Sample("a.png", image, truth)], predictions=lambda network, row, names: [guess[row]],
    )  # fmt: skip
    figure = FIGURES["predictions"].draw(sources)
    (line,) = panels_of(figure, 4)
    assert [panel.get_title() for panel in line] == ["image", "ground truth", "C", "FS-498"]
    assert line[0].get_ylabel() == "BiSeNet"
    shown = [panel.images[0].get_array() for panel in line]
    np.testing.assert_array_equal(shown, [image, *(colour(ids) for ids in (truth, *guess.values()))])
    assert [texts(panel.texts) for panel in line] == [[], [], ["100"], ["50"]]
    assert legend(figure) == [*CLASSES, "not labelled"]


def test_lines_of_errors_are_the_errors_and_zero_lies_at_the_bottom() -> None:
    curves = {"t": {"float64": ([1, 2], [1e-16, 0.0]), "float16": ([1, 2], [1e-3, 1.0])}}
    curves["1 - t"] = {f"{form}, {how}": ([1, 2], [0.1, 0.2]) for form in ("float64", "float16") for how in "ab"}
    one, two = errors(curves).axes
    assert one.get_ylabel() == "relative error of t"
    lines = {line.get_label(): line for line in one.lines if line.get_label() in curves["t"]}
    np.testing.assert_array_equal(lines["float64"].get_xydata(), [[1, 1e-16], [2, LOWEST]])
    assert texts(two.get_legend().get_texts()) == list(curves["1 - t"])
    styles = {line.get_label(): (line.get_color(), line.get_linestyle()) for line in two.lines}
    assert styles["float64, a"][0] == styles["float64, b"][0] == lines["float64"].get_color()
    assert [styles[f"float16, {how}"][1] for how in "ab"] == ["-", "--"]


def test_the_front_of_errors_joins_its_points_and_names_all() -> None:
    figure = errors_front(
        [("exact", 10, 0.0), ("rough", 5, 0.1), ("worse", 6, 0.2)], ["exact", "rough"], "ms", "levels"
    )
    (panel,) = figure.axes
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("ms", "levels")
    assert {"exact", "rough", "worse"} <= set(texts(panel.texts))
    front = next(line for line in panel.lines if line.get_label() == "Pareto front")
    np.testing.assert_array_equal(front.get_xydata(), [[5, 0.1], [10, NONE]])
    filled = {
        line.get_xdata()[0]
        for line in panel.lines
        if line.get_marker() == "o" and line.get_markerfacecolor() != "white"
    }
    assert filled == {5, 10}


def test_the_front_of_accuracy_has_a_point_for_each_way_and_scale() -> None:
    points = [
        ("BiSeNet", "float32", 1.0, 10.0, 60.0),
        ("BiSeNet", "float32", 0.5, 4.0, 50.0),
        ("RefineNet", "int8", 1.0, 20.0, 55.0),
    ]
    figure = accuracy_front(points, [True, True, False], "ms", "mean IoU (%)", [None, (48.0, 51.0), (54.0, 55.5)])
    (panel,) = figure.axes
    bars = [segment.tolist() for bar in panel.collections for segment in bar.get_segments()]
    assert bars == [[[4.0, 48.0], [4.0, 51.0]], [[20.0, 54.0], [20.0, 55.5]]]
    marks = {line.get_xydata()[0].tolist()[0]: line for line in panel.lines if line.get_marker() not in ("", "None")}
    assert {x: line.get_ydata()[0] for x, line in marks.items()} == {10.0: 60.0, 4.0: 50.0, 20.0: 55.0}
    assert [marks[x].get_markeredgecolor() for x in (10.0, 4.0, 20.0)] == ["black", "black", "white"]
    assert marks[10.0].get_marker() != marks[4.0].get_marker()
    assert legend(figure) == [
        "float32", "int8", "scale 1", "scale 0.5", "BiSeNet", "RefineNet", "Pareto front",
    ]  # fmt: skip
