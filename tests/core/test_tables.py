"""Tables as text: rounding, bold marks, escapes, and our runs beside the paper's."""

import io

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from foggy_synscapes.labels import CLASSES
from foggy_synscapes.scoring.metrics import summarize
from foggy_synscapes.tables import formats
from foggy_synscapes.tables.ours import NAMES, annotated_classes, collect, long_csv, tables
from foggy_synscapes.tables.published import load
from foggy_synscapes.tables.table import LABELS, Table, best, images_text, round_half_up, signed

LABELLED = {
    "C": ("C", "-", ""),
    "FS-24500": ("C", "FS", images_text(24500, 600)),
    "C-control": ("C", "C (control)", images_text(None, 400)),
}


def scores(right: float, absent: tuple[int, ...] = (), images: int = 24) -> dict:
    """Metrics of a model that is right on a share of each class's pixels, and says "car" elsewhere."""
    matrix = np.zeros((19, 20), np.int64)
    for number in range(19):
        pixels = 0 if number in absent else 1000
        matrix[number, 13] += pixels - round(right * pixels)
        matrix[number, number] += round(right * pixels)
    return summarize(matrix, images)


def results_of(runs: dict, rows=tuple(LABELLED), test_set="foggy_zurich", networks=("bisenet",), seeds=1):
    full = {
        (n, row): dict(zip(map(str, range(seeds)), runs.get((n, row), [None] * seeds), strict=True))
        for n in networks
        for row in rows
    }
    return collect(LABELLED, full, load(test_set))


def lines_of(results, test_set="foggy_zurich") -> pd.DataFrame:
    return pd.read_csv(io.StringIO(long_csv(test_set, results)), dtype=str, keep_default_na=False)


@pytest.mark.parametrize(
    ("value", "printed"),
    [
        (0.05, "0.1"),
        (0.25, "0.3"),
        (0.35, "0.4"),
        (1.15, "1.2"),
        (30.85, "30.9"),
        (44.4499999, "44.4"),
        (100.0, "100.0"),
    ],
)
def test_halves_are_rounded_up(value, printed):
    assert str(round_half_up(value)) == printed


def test_rounding_is_done_once():
    """34.449 rounded to two digits and then to one would be 34.5."""
    assert str(round_half_up(34.449)) == "34.4"


def test_negative_zero_is_not_printed():
    assert (str(round_half_up(-0.04)), signed(-0.04), signed(-0.05)) == ("0.0", "0.0", "-0.1")


@settings(deadline=None)
@given(st.lists(st.one_of(st.none(), st.integers(0, 1000)), min_size=1, max_size=6))
def test_bold_are_all_largest_values_unless_zero(tenths):
    column = pd.Series([None if value is None else value / 10 for value in tenths], dtype=float)
    marks = best(pd.DataFrame({"road": column}).set_axis(["BiSeNet"] * len(column)))["road"].to_numpy()
    top = column.max()
    assert set(column[marks]) == ({top} if top > 0 else set())
    assert sum(marks) == (column.eq(top).sum() if top > 0 else 0)


@pytest.mark.parametrize(
    ("text", "escaped"),
    [
        ("50 % of R&D", r"50 \% of R\&D"),
        ("#1 cost_$ {x}", r"\#1 cost\_\$ \{x\}"),
        ("a\\b~c^d", r"a\textbackslash{}b\textasciitilde{}c\textasciicircum{}d"),
        ("x<y>z|w", r"x\textless{}y\textgreater{}z\textbar{}w"),
        ("24,500 -> 600 here", r"24,500 $\to$ 600 here"),
        ("two\nlines\ttab\x00", "two lines tab "),
        ("β = 0.005 ± 0", r"$\beta$ = 0.005 $\pm$ 0"),
    ],
)
def test_latex_prints_labels_as_they_are(text, escaped):
    assert formats.escape_latex(text) == escaped


@given(st.text(max_size=30))
def test_no_label_can_break_out_of_its_latex_cell(text):
    """Without the escapes made here, nothing that LaTeX acts on is left."""
    left = formats.escape_latex(text)
    for made in sorted({*formats._LATEX.values(), r"$\to$"}, key=len, reverse=True):
        left = left.replace(made, "")
    assert not set(left) & set("\\{}$&#^_~%\n\r")


def test_markdown_labels_cannot_break_the_table():
    assert formats.escape_markdown("a|b\nc*d_e`<i>") == r"a\|b c\*d\_e\`\<i>"


def test_labels_with_special_characters_reach_latex_escaped():
    index = pd.MultiIndex.from_tuples([("N#1", "x")], names=["network", "row"])
    labels = pd.DataFrame([["C_1", "F&S", "1 -> 2"]], index=index, columns=LABELS)
    cells = pd.DataFrame([["1.0"]], index=index, columns=["a_b"])
    text = formats.latex([Table("x", "50 % & more", labels, cells, cells == "1.0")], "")
    assert r"\caption{50 \% \& more}" in text
    assert r"{a\_b}" in text
    assert r"N\#1" in text
    assert r"& C\_1 & \makebox" in text
    assert r"F\&S \hfill (1 $\to$ 2)" in text
    assert r"\textbf{1.0} \\" in text


def test_a_run_that_does_not_exist_prints_two_dashes():
    results = results_of({("bisenet", "C"): [scores(0.5, absent=(16,))]})
    table = tables("foggy_zurich", results, list(CLASSES[:16]), stand_in=False)[0]
    assert set(table.cells.loc["BiSeNet", "FS-24500"]) == {"--"}
    assert not table.bold.loc["BiSeNet", "FS-24500"].any()
    assert list(table.cells.loc["BiSeNet", "C"][["road", "train"]]) == ["50.0", "-"]
    missing = lines_of(results).query("row == 'FS-24500'")
    assert set(missing["ours"]) == set(missing["seed_0"]) == {"--"}
    assert missing["published"].iloc[0] == "71.6"


def test_both_mean_conventions_are_printed_and_named():
    made = scores(0.5, absent=(16,))
    results = results_of({("bisenet", "C"): [made]}, rows=("C",))
    table = tables("foggy_zurich", results, annotated_classes([made]), stand_in=True)[0]
    assert list(table.cells)[-2:] == ["mean IoU, 18 annotated", "mean IoU, 19 as published"]
    means = made["mean_iou"]
    assert list(table.cells.iloc[0, -2:]) == [
        str(round_half_up(means["annotated"])),
        str(round_half_up(means["as_published"])),
    ]
    assert "not train" in " ".join(table.notes)


def test_stand_in_is_said_in_the_caption():
    results = results_of({})
    for stand_in in (True, False):
        captions = [table.caption for table in tables("foggy_zurich", results, None, stand_in)]
        assert all(("stand-in" in caption) == stand_in for caption in captions)


def test_difference_is_ours_minus_published():
    results = results_of({("bisenet", "C"): [scores(0.5)]}, rows=("C", "C-control"))
    _, means, difference = tables("foggy_zurich", results, list(CLASSES), stand_in=False)
    assert difference.cells.loc["BiSeNet", "C"]["road"] == "-17.1"  # 50.0 - 67.1
    assert difference.cells.loc["BiSeNet", "C"]["train"] == "--"  # the paper has a dash
    assert set(difference.cells.loc["BiSeNet", "C-control"]) == {"--"}  # the control is not in the paper
    assert list(means.cells.loc["BiSeNet", "C"].xs("paper", level=1)) == ["17.0", "16.1"]
    assert r"& $-$17.1 &" in formats.latex([difference], "")


def test_a_class_that_our_ground_truth_lacks_has_no_difference_but_a_dash():
    results = results_of({("bisenet", "C"): [scores(0.5, absent=(0,))]}, rows=("C",))
    difference = tables("foggy_zurich", results, list(CLASSES[1:]), stand_in=False)[2]
    assert difference.cells.loc["BiSeNet", "C"]["road"] == "-"


def test_a_test_set_that_the_paper_lacks_has_one_table():
    results = results_of({("bisenet", "C"): [scores(0.5)]}, rows=("C",), test_set="cityscapes")
    assert len(tables("cityscapes", results, list(CLASSES), stand_in=False)) == 1


def test_mean_and_deviation_over_seeds():
    results = results_of({("bisenet", "C"): [scores(0.4), scores(0.6), None]}, rows=("C",), seeds=3)
    road = results.scores.loc[("BiSeNet", "C", "road")]
    assert (road["ours"], road["std"]) == (50.0, pytest.approx(200**0.5))
    table = tables("foggy_zurich", results, list(CLASSES), stand_in=False)[0]
    assert table.cells["road"].iloc[0] == "50.0"
    assert " ± " in table.cells.iloc[0, -1]
    assert r" $\pm$ " in formats.latex([table], "")
    assert "Fewer seeds than asked for: BiSeNet C (2 of 3)." in table.notes
    first = lines_of(results).iloc[0]
    assert list(first[["seed_0", "seed_1", "seed_2"]]) == ["40.0", "60.0", "--"]
    assert float(first["std"]) == pytest.approx(200**0.5)


def test_rows_whose_intervals_overlap_are_not_ranked():
    """Half a width is 4.30 deviations / sqrt(3): C and FS overlap, the control lies 30 points below both."""
    runs = {
        ("bisenet", "C"): [scores(0.60), scores(0.62), scores(0.64)],
        ("bisenet", "FS-24500"): [scores(0.61), scores(0.60), scores(0.62)],
        ("bisenet", "C-control"): [scores(0.30), scores(0.31), scores(0.32)],
    }
    ours, means, _ = tables("foggy_zurich", results_of(runs, seeds=3), list(CLASSES), stand_in=False)
    for marks in (ours.bold.loc["BiSeNet", "road"], means.bold.loc["BiSeNet", ("19 annotated", "ours")]):
        assert marks.to_dict() == {"C": True, "FS-24500": True, "C-control": False}
    (note,) = [note for note in ours.notes if "Mean over seeds" in note]
    assert note.endswith("1 of 3 pairs of rows of a network change their order with the seed.")
    runs["bisenet", "FS-24500"] = [scores(0.50)] * 3
    apart = tables("foggy_zurich", results_of(runs, seeds=3), list(CLASSES), stand_in=False)[0]
    assert apart.bold.loc["BiSeNet", "road"].to_dict() == {"C": True, "FS-24500": False, "C-control": False}


def test_a_row_of_one_seed_is_as_uncertain_as_the_most_uncertain_one():
    printed = pd.DataFrame({"road": [60.0, 55.0, 20.0]}, index=["N"] * 3)
    margins = pd.DataFrame({"road": [4.0, np.nan, 2.0]}, index=["N"] * 3)
    assert best(printed, margins)["road"].tolist() == [True, True, False]
    assert best(printed, margins * 0)["road"].tolist() == best(printed)["road"].tolist() == [True, False, False]


def test_one_seed_has_no_deviation():
    results = results_of({("bisenet", "C"): [scores(0.4)]}, rows=("C",))
    assert set(lines_of(results)["std"]) == {""}
    assert "±" not in formats.markdown(tables("foggy_zurich", results, list(CLASSES), stand_in=False))


def test_csv_holds_unrounded_values_and_every_score():
    lines = lines_of(results_of({("bisenet", "C"): [scores(1 / 3)]}, rows=("C",)))
    assert list(lines["score"]) == list(NAMES)
    assert float(lines["ours"][0]) == 100 * 0.333
    assert float(lines["difference"][0]) == 100 * 0.333 - 67.1


def test_bold_is_decided_on_what_is_printed_within_each_network():
    runs = {
        ("bisenet", "C"): [scores(0.5001)],
        ("bisenet", "FS-24500"): [scores(0.5)],
        ("refinenet", "C"): [scores(0.9)],
    }
    results = results_of(runs, rows=("C", "FS-24500"), networks=("refinenet", "bisenet"))
    table = tables("foggy_zurich", results, list(CLASSES), stand_in=False)[0]
    assert list(table.cells.index.unique("network")) == ["RefineNet", "BiSeNet"]
    assert list(table.bold.loc["BiSeNet"]["road"]) == [True, True]


def test_the_page_begins_with_the_means():
    results = results_of({("bisenet", "C"): [scores(0.5)]}, rows=("C",))
    page = formats.html(tables("foggy_zurich", results, list(CLASSES), stand_in=False), "t")
    assert page.index("mean IoU, 19 annotated</th>") < page.index("road</th>")
    assert page == formats.html(tables("foggy_zurich", results, list(CLASSES), stand_in=False), "t")


def test_runs_scored_against_other_labels_are_refused():
    with pytest.raises(ValueError, match="not the same label maps"):
        annotated_classes([scores(0.5), scores(0.6, absent=(16,))])
    with pytest.raises(ValueError, match="scored on 12 images"):
        annotated_classes([scores(0.5), scores(0.6, images=12)])
    assert annotated_classes([]) is None


def test_rows_of_the_means_table_are_grouped_in_latex():
    results = results_of({("bisenet", "C"): [scores(0.5, absent=(16,))]}, rows=("C",))
    means = tables("foggy_zurich", results, list(CLASSES[:16] + CLASSES[17:]), stand_in=False)[1]
    text = formats.latex([means], "")
    assert r"\multicolumn{3}{c}{18 annotated} & \multicolumn{3}{c}{19 as published}" in text
    assert r"\cmidrule(lr){4-6} \cmidrule(lr){7-9}" in text
