"""Both engines run the whole chain on the smallest params, and make the same bytes."""

import json
from pathlib import Path

from engines import clone, hashes, run

from foggy_synscapes.datasets import DATASETS
from foggy_synscapes.io.images import encode_png, read_ids
from foggy_synscapes.io.shards import Shard
from foggy_synscapes.io.tables import read_csv
from foggy_synscapes.labels import from_train_ids
from foggy_synscapes.params import load

TABLES = [
    f"results/tables/{name}.{ending}" for name in ("foggy_driving", "foggy_zurich") for ending in ("csv", "tex", "md")
]


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
        index = {line["path"]: line["sha256"] for line in listed}
        pairs = DATASETS[test_set].test_pairs(root, index, load(snakemake / "params/smoke.yaml").scenes)
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
