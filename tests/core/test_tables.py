"""Tables as text: rounding, bold marks, escapes, and our runs beside the paper's."""

from decimal import Decimal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from foggy_synscapes.labels import CLASSES
from foggy_synscapes.scoring.metrics import summarize
from foggy_synscapes.tables import latex, markdown
from foggy_synscapes.tables.grid import Block, Cell, Grid, Head, Line
from foggy_synscapes.tables.numbers import best, round_half_up, signed
from foggy_synscapes.tables.ours import grids, long_columns
from foggy_synscapes.tables.published import load
from foggy_synscapes.tables.results import ANNOTATED, AS_PUBLISHED, RowLabel, Score, annotated_classes, collect

C = RowLabel("C", "C", "-", None, None)
FS = RowLabel("FS-24500", "C", "FS", 24500, 600)
CONTROL = RowLabel("C-control", "C", "C (control)", None, 400)


def scores(right: float, absent: tuple[int, ...] = (), images: int = 24) -> dict:
    """Metrics of a model that is right on a share of each class's pixels, and says "car" elsewhere."""
    matrix = np.zeros((19, 20), np.int64)
    for number in range(19):
        pixels = 0 if number in absent else 1000
        matrix[number, 13] += pixels - round(right * pixels)
        matrix[number, number] += round(right * pixels)
    return summarize(matrix, images)


def results_of(runs: dict, labels=(C, FS, CONTROL), test_set="foggy_zurich", networks=("bisenet",), seeds=1):
    full = {(n, label.row): runs.get((n, label.row), [None] * seeds) for n in networks for label in labels}
    return collect(networks, labels, full, load(test_set))


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


@given(st.lists(st.one_of(st.none(), st.decimals(0, 100, places=1)), max_size=6))
def test_bold_are_all_largest_values_unless_zero(column):
    marks = best(column)
    bold = {value for value, mark in zip(column, marks, strict=True) if mark}
    top = max((value for value in column if value is not None), default=Decimal(0))
    assert bold == ({top} if top > 0 else set())
    assert sum(marks) == (column.count(top) if top > 0 else 0)


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
    assert latex.escape(text) == escaped


@given(st.text(max_size=30))
def test_no_label_can_break_out_of_its_latex_cell(text):
    """Without the escapes made here, nothing that LaTeX acts on is left."""
    left = latex.escape(text)
    for made in sorted({*latex._SPECIAL.values(), r"$\to$"}, key=len, reverse=True):
        left = left.replace(made, "")
    assert not set(left) & set("\\{}$&#^_~%\n\r")


def test_markdown_labels_cannot_break_the_table():
    assert markdown.escape("a|b\nc*d_e`<i>") == r"a\|b c\*d\_e\`\<i>"


def test_labels_with_special_characters_reach_latex_escaped():
    grid = Grid("x", "50 % & more", [Head("a_b")], [Block("N#1", [Line("C_1", "F&S", "1 -> 2", [Cell("1.0", True)])])])
    text = latex.table(grid)
    assert r"\caption{50 \% \& more}" in text
    assert r"{a\_b}" in text
    assert r"N\#1" in text
    assert r"& C\_1 & \makebox" in text
    assert r"F\&S \hfill (1 $\to$ 2)" in text
    assert r"\textbf{1.0} \\" in text


def test_counts_say_how_they_were_scaled():
    assert [label.images_text for label in (C, FS, CONTROL)] == ["", "24,500 -> 600 here", "400 here"]
    assert RowLabel("FS-498", "C", "FS", 498, 498).images_text == "498"


def test_a_run_that_does_not_exist_prints_two_dashes():
    results = results_of({("bisenet", "C"): [scores(0.5, absent=(16,))]})
    table = grids("foggy_zurich", results, list(CLASSES[:16]), ["0"], stand_in=False)[0]
    lines = table.blocks[0].lines
    assert {cell.text for cell in lines[1].cells} == {"--"}
    assert not any(cell.bold for cell in lines[1].cells)
    assert lines[0].cells[0].text == "50.0"
    assert lines[0].cells[16].text == "-"
    columns, rows = long_columns("foggy_zurich", results, ["0"])
    missing = [row for row in rows if row[columns.index("row")] == "FS-24500"]
    assert {row[columns.index("ours")] for row in missing} == {"--"}
    assert {row[columns.index("seed_0")] for row in missing} == {"--"}
    assert missing[0][columns.index("published")] == "71.6"


def test_both_mean_conventions_are_printed_and_named():
    made = scores(0.5, absent=(16,))
    results = results_of({("bisenet", "C"): [made]}, labels=(C,))
    table = grids("foggy_zurich", results, annotated_classes([made]), ["0"], stand_in=True)[0]
    assert [head.text for head in table.heads[-2:]] == ["mean IoU, 18 annotated", "mean IoU, 19 as published"]
    means = made["mean_iou"]
    assert [cell.text for cell in table.blocks[0].lines[0].cells[-2:]] == [
        str(round_half_up(means["annotated"])),
        str(round_half_up(means["as_published"])),
    ]
    assert "not train" in " ".join(table.notes)


def test_stand_in_is_said_in_the_caption():
    results = results_of({})
    for stand_in in (True, False):
        captions = [grid.caption for grid in grids("foggy_zurich", results, None, ["0"], stand_in)]
        assert all(("stand-in" in caption) == stand_in for caption in captions)


def test_difference_is_ours_minus_published():
    results = results_of({("bisenet", "C"): [scores(0.5)]}, labels=(C, CONTROL))
    _, means, difference = grids("foggy_zurich", results, list(CLASSES), ["0"], stand_in=False)
    assert difference.blocks[0].lines[0].cells[0].text == "-17.1"  # 50.0 - 67.1
    assert difference.blocks[0].lines[0].cells[16].text == "--"  # the paper has a dash
    assert {cell.text for cell in difference.blocks[0].lines[1].cells} == {"--"}  # the control is not in the paper
    assert [cell.text for cell in means.blocks[0].lines[0].cells[::3]] == ["17.0", "16.1"]
    assert r"& $-$17.1 &" in latex.table(difference)


def test_a_test_set_that_the_paper_lacks_has_one_table():
    results = results_of({("bisenet", "C"): [scores(0.5)]}, labels=(C,), test_set="cityscapes")
    assert len(grids("cityscapes", results, list(CLASSES), ["0"], stand_in=False)) == 1


def test_mean_and_spread_over_seeds():
    score = Score(None, (40.0, 42.0, 47.0))
    assert (score.mean, score.spread) == (43.0, pytest.approx(13**0.5))
    assert Score(None, (40.0,)).spread is None
    results = results_of({("bisenet", "C"): [scores(0.4), scores(0.6), None]}, labels=(C,), seeds=3)
    table = grids("foggy_zurich", results, list(CLASSES), ["0", "1", "2"], stand_in=False)[0]
    assert table.blocks[0].lines[0].cells[0].text == "50.0"
    assert " ± " in table.blocks[0].lines[0].cells[-1].text
    assert r" $\pm$ " in latex.table(table)
    assert "Fewer seeds than asked for: BiSeNet C (2 of 3)." in table.notes
    columns, rows = long_columns("foggy_zurich", results, ["0", "1", "2"])
    assert rows[0][columns.index("seed_0") :] == ["40.0", "60.0", "--"]
    assert float(rows[0][columns.index("spread")]) == pytest.approx(200**0.5)


def test_csv_holds_unrounded_values_and_every_score():
    results = results_of({("bisenet", "C"): [scores(1 / 3)]}, labels=(C,))
    columns, rows = long_columns("foggy_zurich", results, ["0"])
    assert [row[columns.index("score")] for row in rows] == [*CLASSES, ANNOTATED, AS_PUBLISHED]
    assert float(rows[0][columns.index("ours")]) == 100 * 0.333
    assert float(rows[0][columns.index("difference")]) == 100 * 0.333 - 67.1


def test_bold_is_decided_on_what_is_printed_within_each_network():
    runs = {
        ("bisenet", "C"): [scores(0.5001)],
        ("bisenet", "FS-24500"): [scores(0.5)],
        ("refinenet", "C"): [scores(0.9)],
    }
    results = results_of(runs, labels=(C, FS), networks=("refinenet", "bisenet"))
    table = grids("foggy_zurich", results, list(CLASSES), ["0"], stand_in=False)[0]
    bisenet = table.blocks[1]
    assert (bisenet.network, bisenet.lines[0].cells[0].bold, bisenet.lines[1].cells[0].bold) == ("BiSeNet", True, True)


def test_runs_scored_against_other_labels_are_refused():
    with pytest.raises(ValueError, match="not the same label maps"):
        annotated_classes([scores(0.5), scores(0.6, absent=(16,))])
    with pytest.raises(ValueError, match="scored on 12 images"):
        annotated_classes([scores(0.5), scores(0.6, images=12)])
    assert annotated_classes([]) is None


def test_rows_of_the_means_table_are_grouped_in_latex():
    results = results_of({("bisenet", "C"): [scores(0.5, absent=(16,))]}, labels=(C,))
    means = grids("foggy_zurich", results, list(CLASSES[:16] + CLASSES[17:]), ["0"], stand_in=False)[1]
    text = latex.table(means)
    assert r"\multicolumn{3}{c}{18 annotated} & \multicolumn{3}{c}{19 as published}" in text
    assert r"\cmidrule(lr){4-6} \cmidrule(lr){7-9}" in text
