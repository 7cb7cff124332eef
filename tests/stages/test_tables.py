"""tables: CSV, LaTeX and Markdown from the metrics that exist, and the published tables from their numbers."""

import csv
import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from records import vouch

from foggy_synscapes.cli import main
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.plain_yaml import read_yaml
from foggy_synscapes.scoring.metrics import summarize

ROOT = Path(__file__).resolve().parents[2]
WRAPPER = r"""\documentclass[a4paper]{article}
\usepackage[margin=2cm]{geometry}
\usepackage{booktabs,graphicx,multirow}
\begin{document}
%s
\end{document}
"""


def metrics_path(row: str, network: str = "bisenet", seed: str = "0", test_set: str = "foggy_zurich") -> Path:
    return Path(f"results/evaluate/{test_set}/{network}/{row}/seed-{seed}/metrics.json")


def put_metrics(path: Path, seed: int = 0, absent: tuple[int, ...] = (16,)) -> dict:
    rng = np.random.default_rng(seed)
    matrix = np.zeros((19, 20), np.int64)
    for number in set(range(19)) - set(absent):
        right = rng.integers(0, 1001)
        matrix[number, [number, (number + 1) % 19]] = right, 1000 - right
    scores = summarize(matrix, images=24)
    write_text(path, json.dumps(scores))
    vouch(path)
    return scores


@pytest.fixture
def document(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict:
    monkeypatch.chdir(tmp_path)
    return read_yaml(ROOT / "params.yaml")


def tables(document: dict, test_set: str = "foggy_zurich") -> int:
    write_text(Path("params.yaml"), json.dumps(document))
    return main(["tables", "--test-set", test_set])


def rows_of(path: Path) -> list[dict[str, str]]:
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def refused(document: dict, capsys: pytest.CaptureFixture) -> str:
    assert tables(document) == 1
    message = capsys.readouterr().err
    assert "Traceback" not in message
    assert not Path("results/tables").exists()
    return message


def test_writes_csv_latex_markdown_html_and_a_record(document):
    scores = put_metrics(metrics_path("C"))
    assert tables(document) == 0
    rows = rows_of(Path("results/tables/foggy_zurich.csv"))
    assert len(rows) == 2 * 6 * 21
    means = [r for r in rows if (r["network"], r["row"], r["score"]) == ("BiSeNet", "C", "mean IoU annotated")]
    assert float(means[0]["ours"]) == scores["mean_iou"]["annotated"]
    assert {r["ours"] for r in rows if r["row"] != "C" or r["network"] != "BiSeNet"} == {"--"}
    latex = Path("results/tables/foggy_zurich.tex").read_text()
    markdown = Path("results/tables/foggy_zurich.md").read_text()
    assert r"24,500 $\to$ 600 here" in latex
    assert "24,500 -> 600 here" in markdown
    assert "stand-in" in latex
    assert "stand-in" in markdown
    page = Path("results/tables/foggy_zurich.html").read_text()
    assert "24,500 -&gt; 600 here" in page
    assert page.count("<table ") == latex.count(r"\begin{tabular}") == 3
    bold = [rule for rule in page.split("}") if "font-weight: bold" in rule]
    assert sum(rule.rpartition("</style>")[2].count("#T_") for rule in bold) == markdown.count("**") / 2
    means = json.loads(Path("results/tables/foggy_zurich.json").read_text())
    assert means == {"BiSeNet": {"C": scores["mean_iou"]["annotated"]}}
    record = json.loads(Path("results/tables/foggy_zurich.run.json").read_text())
    assert list(record["inputs"]) == ["results/evaluate/foggy_zurich/bisenet/C/seed-0/metrics.json"]
    assert sorted(record["outputs"]) == [
        f"results/tables/foggy_zurich.{ending}" for ending in ("csv", "html", "json", "md", "tex")
    ]


def test_nothing_run_at_all_is_a_table_of_dashes(document):
    assert tables(document, "foggy_driving") == 0
    assert {row["ours"] for row in rows_of(Path("results/tables/foggy_driving.csv"))} == {"--"}
    assert "-- & --" in Path("results/tables/foggy_driving.tex").read_text()


def test_the_same_metrics_give_the_same_bytes(document):
    for number, row in enumerate(("C", "FC-498", "FS-498")):
        put_metrics(metrics_path(row), number)
    made = []
    for _ in range(2):
        shutil.rmtree("results/tables", ignore_errors=True)
        assert tables(document) == 0
        made.append({path.name: path.read_bytes() for path in sorted(Path("results/tables").iterdir())})
    assert made[0] == made[1]


def test_several_seeds_are_averaged(document):
    document["train"]["seeds"] = ["0", "1"]
    means = [put_metrics(metrics_path("C", seed=str(seed)), seed)["mean_iou"]["as_published"] for seed in (0, 1)]
    assert tables(document) == 0
    rows = rows_of(Path("results/tables/foggy_zurich.csv"))
    row = next(r for r in rows if (r["network"], r["row"], r["score"]) == ("BiSeNet", "C", "mean IoU as published"))
    assert [float(row["seed_0"]), float(row["seed_1"])] == means
    assert float(row["ours"]) == pytest.approx(sum(means) / 2)
    assert "Mean over seeds 0, 1" in Path("results/tables/foggy_zurich.md").read_text()


def test_a_test_set_without_published_numbers_has_only_ours(document):
    put_metrics(metrics_path("C", test_set="cityscapes"), absent=())
    assert tables(document, "cityscapes") == 0
    assert {row["published"] for row in rows_of(Path("results/tables/cityscapes.csv"))} == {""}
    assert Path("results/tables/cityscapes.tex").read_text().count(r"\begin{table*}") == 1


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda s: s["classes"].pop(), "scores of 18 classes, expected the 19 of Cityscapes"),
        (lambda s: s["classes"][6].update(name="tr.light"), "class 'tr.light' where 'traffic light' is expected"),
        (lambda s: s["classes"].reverse(), "class 'bicycle' where 'road' is expected"),
        (lambda s: s["classes"][0].update(iou=170.0), "IoU 170.0, expected 0 to 100 percent"),
        (lambda s: s["classes"][0].update(iou=float("nan")), "IoU nan"),
        (lambda s: s["classes"][0].update(tp=-1), "count -1"),
        (lambda s: s["mean_iou"].pop("annotated"), "not the scores of a test set"),
        (lambda s: s.pop("annotated_classes"), "not the scores of a test set"),
        (lambda s: s.update(annotated_classes=19), "19 annotated classes, but"),
        (lambda s: s.update(images="24"), "count '24'"),
    ],
)
def test_metrics_of_another_form_are_refused(document, capsys, change, message):
    scores = put_metrics(metrics_path("FS-498"))
    change(scores)
    write_text(metrics_path("FS-498"), json.dumps(scores))
    vouch()
    said = refused(document, capsys)
    assert message in said
    assert str(metrics_path("FS-498")) in said


@pytest.mark.parametrize("text", ["", "{", "[]", "null", "\xff\x00"])
def test_a_damaged_metrics_file_is_refused(document, capsys, text):
    write_text(metrics_path("C"), text)
    vouch()
    assert str(metrics_path("C")) in refused(document, capsys)


def test_runs_scored_against_other_labels_are_refused(document, capsys):
    put_metrics(metrics_path("C", network="refinenet"))
    put_metrics(metrics_path("C"), absent=(3, 16))
    said = refused(document, capsys)
    assert str(metrics_path("C")) in said
    assert "not the same label maps" in said


@pytest.mark.parametrize(
    "arguments", [[], ["--published"], ["--test-set", "acdc"], ["--published", "--test-set", "cityscapes"]]
)
def test_a_wrong_call_ends_with_status_2(arguments, capsys):
    assert main(["tables", *arguments]) == 2


def test_published_tables_are_written_as_files(tmp_path):
    assert main(["tables", "--published", "--out", str(tmp_path / "out")]) == 0
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == sorted(
        f"{name}.{ending}" for name in ("foggy_driving", "foggy_zurich") for ending in ("csv", "md", "tex")
    )
    rows = rows_of(tmp_path / "out/foggy_zurich.csv")
    assert len(rows) == 10
    assert {row["train"] for row in rows} == {"-"}
    assert rows[4]["mean IoU"] == "41.4"


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="no pdflatex; Debian: texlive-latex-extra")
def test_every_table_compiles(document):
    """Also with labels of special characters, several seeds and runs that were not made."""
    document["train"]["seeds"] = ["0", "1"]
    document["tables"]["rows"][1] |= {"training": "50 % & _x#", "fine_tuning": "a\\b{c}^d~e$f <|>"}
    for seed in ("0", "1"):
        put_metrics(metrics_path("C", seed=seed), int(seed))
        put_metrics(metrics_path("C", seed=seed, test_set="cityscapes"), int(seed), absent=())
    inputs = []
    for test_set in ("foggy_zurich", "cityscapes"):
        assert tables(document, test_set) == 0
        inputs.append(rf"\input{{results/tables/{test_set}.tex}}")
    main(["tables", "--published", "--out", "published"])
    inputs += [r"\input{published/foggy_driving.tex}", r"\input{published/foggy_zurich.tex}"]
    write_text(Path("all.tex"), WRAPPER % "\n".join(inputs))
    command = ["pdflatex", "-halt-on-error", "-interaction=nonstopmode", "all.tex"]
    done = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False)
    assert done.returncode == 0, done.stdout[-2000:]
    assert "Overfull" not in done.stdout
    assert Path("all.pdf").stat().st_size > 10_000


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="no pdflatex; Debian: texlive-latex-extra")
@pytest.mark.parametrize("made", [True, False])
def test_the_article_compiles_whatever_is_made(document, made):
    if made:
        put_metrics(metrics_path("C"))
        assert tables(document) == 0
        assert main(["tables", "--published", "--out", "results/paper"]) == 0
    command = ["pdflatex", "-halt-on-error", "-interaction=nonstopmode", str(ROOT / "paper/article.tex")]
    done = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False)
    assert done.returncode == 0, done.stdout[-2000:]
    assert "Overfull" not in done.stdout
    assert Path("article.pdf").stat().st_size > 10_000


def test_the_papers_rows_alone(document):
    document["subset"]["pure"]["mine"] = document["subset"]["pure"]["FS-498"]
    document["train"]["rows"]["mine"] = document["train"]["rows"]["FS-498"]
    document["train"]["from_baseline"].append("mine")
    document["tables"]["rows"].append({"row": "mine", "training": "C", "fine_tuning": "FS"})
    put_metrics(metrics_path("C"))
    put_metrics(metrics_path("mine"))
    assert tables(document) == 0
    assert main(["tables", "--test-set", "foggy_zurich", "--paper"]) == 0
    whole, own = (rows_of(Path(f"results/tables/{place}foggy_zurich.csv")) for place in ("", "paper/"))
    assert {row["row"] for row in whole} - {row["row"] for row in own} == {"mine", "C-control"}
    assert [row for row in whole if row["row"] in PAPERS_ROWS] == own
    record = json.loads(Path("results/tables/paper/foggy_zurich.run.json").read_text())
    assert str(metrics_path("C")) in record["inputs"]
    assert str(metrics_path("mine")) not in record["inputs"]


PAPERS_ROWS = {"C", "FC-498", "FS-24500", "FS-498", "FC-FS-498"}


def test_the_paper_has_no_table_of_clear_cityscapes(document, capsys):
    assert tables(document) == 0
    assert main(["tables", "--test-set", "cityscapes", "--paper"]) == 2
    assert "foggy_driving, foggy_zurich, none of cityscapes" in capsys.readouterr().err
