"""The published tables: every number and every bold mark, held against the paper's own source."""

import csv
import hashlib
import io
import json
import os
import re
from decimal import Decimal
from pathlib import Path

import pytest

from foggy_synscapes.labels import CLASSES
from foggy_synscapes.tables import formats
from foggy_synscapes.tables.paper import notes, published_csv, published_table
from foggy_synscapes.tables.published import TEST_SETS, load, mean_of_classes
from foggy_synscapes.tables.table import MEAN, round_half_up

ROOT = Path(__file__).resolve().parent.parent.parent
# Of `cells()` below, for both tables: a change of any label, number or bold mark changes it.
DIGEST = "26b6fb1ff13d7943687caa26a3218bb87ddf3864339bc53749e2adbfbeaec43e"
DIGITS = re.compile(r"\d+\.\d|-")


def cells(tex: str) -> list[list[list]]:
    """All rows of a LaTeX table: network, training, fine-tuning with images, then [number, is it bold] by column."""
    rows, network = [], None
    body = re.sub(r"\\(hspace|makebox)(\[[^]]*\]|\{[^}]*\})+?(?=\{|\s|\()", "", tex)
    for line in re.split(r"\\\\\s*\n", body):
        if found := re.search(r"\\multirow.*?(RefineNet|BiSeNet)", line, re.DOTALL):
            network = found[1]
        parts = [part.strip() for part in line.split("&")]
        if network is None or len(parts) != 23:
            continue
        label = re.sub(r"\\hfill|[{}~]", "", parts[2])
        numbers = [[DIGITS.search(part.replace("multicolumn{1}", ""))[0], "textbf" in part] for part in parts[3:]]
        rows.append([network, parts[1], " ".join(label.split()), *numbers])
    return rows


def made_tables() -> list:
    return [cells(formats.latex([published_table(name, load(name))], "")) for name in TEST_SETS]


@pytest.fixture(scope="module")
def paper() -> list[str]:
    path = Path(os.environ.get("FOGGY_PAPER", ROOT.parent / "shared" / "paper" / "foggy_synscapes.tex"))
    if not path.is_file():
        pytest.skip(f"the paper's source is not at {path}; set FOGGY_PAPER to it")
    return path.read_text(encoding="utf-8").split("\n")


def printed_tables(paper: list[str]) -> list:
    # A row of the source may go over several lines and blank lines; "C & FC \hspace{19pt}(498) \n& 91.7" is one.
    tables = re.findall(r"\\begin\{tabular\}.*?\\end\{tabular\}", "\n".join(paper), re.DOTALL)
    return [cells(re.sub(r"\\thead|\n\s*\n", "\n", table)) for table in tables]


def test_every_cell_and_bold_mark_is_as_in_the_paper(paper):
    printed = printed_tables(paper)
    assert [len(table) for table in printed] == [10, 10]
    for ours, theirs in zip(made_tables(), printed, strict=True):
        for mine, its in zip(ours, theirs, strict=True):
            assert mine == its


def test_every_cell_and_bold_mark_is_as_it_was_compared():
    assert sum(len(row) - 3 for table in made_tables() for row in table) == 400
    assert hashlib.sha256(json.dumps(made_tables()).encode()).hexdigest() == DIGEST


def test_source_lines_hold_what_they_are_named_for(paper):
    for name in TEST_SETS:
        for _, row in load(name).iterrows():
            assert row["fine_tuning"] in paper[int(row["label_line"]) - 1]
            for value in row[[*CLASSES, MEAN]].fillna("-"):
                assert str(value) in paper[int(row["value_line"]) - 1]


def test_heads_are_in_the_papers_order(paper):
    heads = re.findall(r"\\rotatebox\[origin=l\]\{90\}\{\\thead\{([^}]*\}?)\}\}", "\n".join(paper))
    table = published_table("foggy_driving", load("foggy_driving"))
    ours = ["Model", *(rf"\textbf{{{head}}}" if head == MEAN else head for _, head in table.heads)]
    assert [head for head in heads if head] == ours * 2


@pytest.mark.parametrize("name", TEST_SETS)
def test_there_are_two_blocks_of_five_rows(name):
    labels = published_table(name, load(name)).labels
    assert list(labels.index.get_level_values("network")) == ["RefineNet"] * 5 + ["BiSeNet"] * 5
    assert list(labels["images"]) == ["", "498", "24,500", "498", "498"] * 2


def test_driving_means_are_over_19():
    rows = load("foggy_driving")
    assert list(mean_of_classes(rows, annotated=True).map(round_half_up)) == list(rows[MEAN])
    assert "All 10 agree" in notes(load("foggy_driving"))[0]


def test_zurich_means_divide_by_19_and_two_are_rounded_otherwise():
    rows = load("foggy_zurich")
    recomputed = mean_of_classes(rows, annotated=False)
    odd = {
        key: (round_half_up(recomputed[key], 2), mean)
        for key, mean in rows[MEAN].items()
        if round_half_up(recomputed[key]) != mean
    }
    assert odd == {
        ("RefineNet", "FS-498"): (Decimal("42.76"), Decimal("42.7")),
        ("BiSeNet", "FC-FS-498"): (Decimal("30.85"), Decimal("30.9")),
    }
    text = " ".join(notes(rows))
    assert "8 of 10 agree" in text
    assert "RefineNet FS (498): 42.76 recomputed, 42.7 printed" in text
    assert "BiSeNet FC + FS (498): 30.85 recomputed, 30.9 printed" in text


def test_zurich_means_over_the_18_annotated_classes():
    rows = load("foggy_zurich")
    means = list(mean_of_classes(rows, annotated=True).map(round_half_up).map(str))
    assert means == ["36.5", "38.9", "42.5", "45.1", "43.7", "17.0", "26.4", "29.3", "29.1", "32.6"]
    assert [name for name in CLASSES if rows[name].isna().any()] == ["train"]
    assert rows["train"].isna().all()


def test_a_test_set_that_the_paper_does_not_have_has_no_rows():
    assert load("cityscapes").empty


def test_csv_has_every_cell_as_printed():
    first = next(csv.DictReader(io.StringIO(published_csv(load("foggy_zurich")))))
    assert (first["model"], first["images"], first["road"], first["train"]) == ("RefineNet", "", "74.3", "-")
    assert (first["mean IoU"], first["recomputed mean over 19"], first["source line"]) == ("34.6", "34.55", "270")
