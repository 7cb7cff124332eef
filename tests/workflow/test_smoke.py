"""Both engines run the whole chain on the smallest params, and make the same bytes."""

import hashlib
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from foggy_synscapes.datasets.labels import from_train_ids
from foggy_synscapes.datasets.test_sets import labelled_pairs
from foggy_synscapes.io.images import encode_png, read_ids
from foggy_synscapes.io.shards import Shard
from foggy_synscapes.io.tables import read_csv

ROOT = Path(__file__).resolve().parents[2]
PROJECT = (
    "Snakefile",
    "workflow",
    "src",
    "params",
    "params.yaml",
    "dvc.yaml",
    ".dvc/config",
    ".dvcignore",
    ".gitignore",
)
TABLES = [
    f"results/tables/{name}.{ending}" for name in ("foggy_driving", "foggy_zurich") for ending in ("csv", "tex", "md")
]


def clone(folder: Path) -> Path:
    """A copy of the project's files, as it stands, without results."""
    for name in PROJECT:
        source, target = ROOT / name, folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if source.is_dir():
            shutil.copytree(source, target, ignore=shutil.ignore_patterns("__pycache__", "*.egg-info"))
        else:
            shutil.copy(source, target)
    return folder


def run(folder: Path, module: str, *arguments: str) -> str:
    """Run an engine of this environment in a folder; its output, also where it fails, which is an error."""
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    call = [sys.executable, "-m", module, *arguments]
    result = subprocess.run(call, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    logs = [] if result.returncode == 0 else sorted((folder / "results/logs").rglob("*.log"))
    told = "".join(
        f"\n--- {log}\n{log.read_text()}" for log in logs if "Error" in log.read_text() or "foggy " in log.read_text()
    )
    assert result.returncode == 0, result.stdout[-3000:] + result.stderr[-5000:] + told[-5000:]
    return result.stdout + result.stderr


def hashes(folder: Path) -> dict[str, str]:
    """SHA-256 of every result that is not a log, a benchmark or a cache."""
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted((folder / "results").rglob("*"))
        if path.is_file()
        and path.relative_to(folder / "results").parts[0] not in ("logs", "benchmarks")
        and path.name not in (".gitignore", ".snakemake_timestamp")
    }


@pytest.fixture(scope="module")
def snakemake(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A clone, in a folder with spaces and quotes, in which Snakemake ran the chain on two cores."""
    folder = clone(tmp_path_factory.mktemp("it's a clone"))
    run(folder, "snakemake", "--cores", "2", "--configfile", "params/smoke.yaml")
    return folder


@pytest.fixture(scope="module")
def dvc(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A clone in which DVC ran the chain."""
    folder = clone(tmp_path_factory.mktemp("clone"))
    shutil.copy(folder / "params/smoke.yaml", folder / "params.yaml")
    subprocess.run(["git", "init", "--quiet"], cwd=folder, check=True)
    run(folder, "dvc", "repro")
    return folder


def test_every_trained_row_has_scores_and_an_untrained_one_has_dashes(snakemake: Path) -> None:
    for name in ("foggy_driving", "foggy_zurich"):
        text = (snakemake / f"results/tables/{name}.tex").read_text()
        assert "stand-in" in text.lower()
        assert "C (control)" in text
        assert "--" in next(line for line in text.splitlines() if "C (control)" in line)
        assert "--" not in next(line for line in text.splitlines() if "FC + FS" in line).replace("---", "")


def test_a_second_run_of_snakemake_does_nothing_and_says_so(snakemake: Path) -> None:
    before = hashes(snakemake)
    assert "Nothing to be done" in run(snakemake, "snakemake", "--cores", "2", "--configfile", "params/smoke.yaml")
    assert hashes(snakemake) == before


def test_a_second_run_of_dvc_does_nothing_and_says_so(dvc: Path) -> None:
    before = hashes(dvc)
    assert "Data and pipelines are up to date" in run(dvc, "dvc", "repro")
    assert hashes(dvc) == before


def test_both_engines_make_the_same_bytes(snakemake: Path, dvc: Path) -> None:
    ours, theirs = hashes(snakemake), hashes(dvc)
    assert set(TABLES) <= ours.keys()
    assert ours == theirs


def test_results_are_what_their_records_say_and_can_be_traced(snakemake: Path) -> None:
    assert "are what their run records say" in run(snakemake, "foggy_synscapes", "verify")
    tree = run(snakemake, "foggy_synscapes", "trace", "results/tables/foggy_zurich.tex")
    assert "foggy scenes --dataset synscapes" in tree
    assert "<--" not in tree


def test_scores_are_those_of_the_official_scorer(snakemake: Path, tmp_path: Path) -> None:
    from cityscapesscripts.evaluation import evalPixelLevelSemanticLabeling as official

    official.args.evalInstLevelScore = official.args.JSONOutput = False
    official.args.quiet = True
    scored = sorted((snakemake / "results/evaluate").glob("*/*/*/seed-0/metrics.json"))
    assert len(scored) == 20
    for path in scored:
        test_set = path.parents[3].name
        root = snakemake / "results/scenes" / test_set
        listed = read_csv(snakemake / f"results/scenes/index/{test_set}/all.csv")
        pairs = labelled_pairs(test_set, root, {line["path"]: line["sha256"] for line in listed}, "testv2")
        guesses = []
        with Shard(path.with_name("predictions.tar")) as shard:
            for image, _ in pairs:
                guesses.append(str(tmp_path / f"{len(guesses)}.png"))
                Path(guesses[-1]).write_bytes(encode_png(from_train_ids(read_ids(shard.read(image)))))
        expected = official.evaluateImgLists(guesses, [str(root / label) for _, label in pairs], official.args)
        scores = json.loads(path.read_text())
        assert scores["mean_iou_cityscapes"] == 100 * expected["averageScoreClasses"]
        for entry in scores["classes"]:
            assert entry["iou"] in (None, 100 * expected["classScores"][entry["name"]])


def test_no_result_names_the_folder_or_the_user(snakemake: Path) -> None:
    told = [str(snakemake).encode(), str(Path.home()).encode() + b"/"]
    for path in hashes(snakemake):
        data = (snakemake / path).read_bytes()
        assert not [name for name in told if name in data], path


def test_the_paper_can_be_planned_on_stand_in_roots(tmp_path: Path) -> None:
    folder = clone(tmp_path)
    paper = folder / "params/paper.yaml"
    lines = paper.read_text().splitlines()
    roots = [
        f"{line.split(':')[0]}: stand-in" if ": data/" in line and "weights" not in line else line for line in lines
    ]
    (folder / "params/planned.yaml").write_text("\n".join(roots) + "\n")
    told = run(folder, "snakemake", "--dry-run", "--cores", "1", "--configfile", "params/planned.yaml")
    assert "scenes_synscapes" in told


def test_the_report_is_one_page_with_every_table_and_figure(snakemake: Path, tmp_path: Path) -> None:
    page = tmp_path / "report.html"
    run(snakemake, "snakemake", "--configfile", "params/smoke.yaml", "--report", str(page))
    text = page.read_text()
    shown = [*(snakemake / "results/tables").glob("*.html"), *(snakemake / "results/figures").glob("*.png")]
    assert len(shown) > 10
    for path in shown:
        assert path.relative_to(snakemake).as_posix() in text
