"""`foggy card`, `foggy croissant` and `foggy gallery` say of a finished run what its records and scores say."""

import json
import re
from pathlib import Path

import pytest

from foggy_synscapes.cli import main
from foggy_synscapes.io.hashing import sha256
from foggy_synscapes.io.shards import Shard
from foggy_synscapes.tables.table import round_half_up

PARAMS = ("--params", "params/smoke.yaml")
MODEL = Path("results/train/bisenet/FS-498/seed-0/model.safetensors")


@pytest.fixture
def finished(snakemake: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(snakemake)
    return snakemake


def test_a_card_has_the_models_hash_lists_params_and_scores(finished: Path, capsys: pytest.CaptureFixture) -> None:
    assert main(["card", "--network", "bisenet", "--row", "FS-498", *PARAMS]) == 0
    card = capsys.readouterr().out
    assert f"`{MODEL}`, SHA-256 `{sha256(MODEL)}`" in card
    images = len(Path("results/subset/FS-498/train.csv").read_text().splitlines()) - 1
    assert f"- train: {images} images ({images} of Foggy Synscapes made here from stand-in images)" in card
    record = json.loads(MODEL.with_name("run.json").read_text())
    rate = record["params"]["train"]["bisenet"]["fine_tuning"]["learning_rate"]
    assert f"| `train.bisenet.fine_tuning.learning_rate` | {rate} |" in card
    scores = json.loads(Path("results/evaluate/foggy_driving/bisenet/FS-498/seed-0/metrics.json").read_text())
    sky = next(entry["iou"] for entry in scores["classes"] if entry["name"] == "sky")
    assert f"| sky | {round_half_up(sky)} |" in card


def test_no_card_is_written_of_an_altered_model(finished: Path, capsys: pytest.CaptureFixture) -> None:
    kept = MODEL.read_bytes()
    MODEL.write_bytes(kept + b"!")
    try:
        assert main(["card", "--network", "bisenet", "--row", "FS-498", *PARAMS]) == 1
        assert f"{MODEL}: changed, so no card is written" in capsys.readouterr().err
    finally:
        MODEL.write_bytes(kept)
    assert main(["card", "--network", "nothing", "--row", "FS-498", *PARAMS]) == 2
    assert "there are bisenet, refinenet" in capsys.readouterr().err


def test_a_description_names_every_shard_with_its_hash(finished: Path) -> None:
    folder = next(Path("results/fog").glob("beta_*"))
    assert main(["croissant", str(folder), "--date", "2026-11-26", *PARAMS]) == 0
    path = folder.with_name(f"{folder.name}.croissant.json")
    document = json.loads(path.read_text())
    files = [each for each in document["distribution"] if each["@type"] == "cr:FileObject"]
    assert {path.parent / each["contentUrl"]: each["sha256"] for each in files} == {
        shard: sha256(shard) for shard in sorted(folder.glob("*.tar"))
    }
    images = sum(len(Shard(shard).names()) for shard in folder.glob("*.tar"))
    assert document["description"].startswith(f"{images} foggy images of Synscapes, made of stand-in images")
    path.unlink()


def test_a_description_of_nothing_or_without_a_date_is_refused(finished: Path, capsys: pytest.CaptureFixture) -> None:
    assert main(["croissant", "results/filter", "--date", "2026-11-26", *PARAMS]) == 1
    assert "results/filter: no foggy images in shards" in capsys.readouterr().err
    assert main(["croissant", "results/filter", "--date", "today", *PARAMS]) == 2
    assert "--date today: expected year, month and day" in capsys.readouterr().err


def test_the_gallery_shows_every_table_and_figure_without_the_web(finished: Path) -> None:
    assert main(["gallery", "--out", "gallery.html", *PARAMS]) == 0
    page = Path("gallery.html").read_text(encoding="utf-8")
    made = sorted(path.stem for path in Path("results/figures").glob("*.png"))
    assert sorted(re.findall(r'<img alt="(\w+)" src="data:image/png;base64,', page)) == made
    for table in Path("results/tables").glob("*.html"):
        assert re.sub(r".*<body>|</body>.*", "", table.read_text(), flags=re.DOTALL) in page
    assert not re.search(r'(?:src|href)="(?!#|data:)', page)
    Path("gallery.html").unlink()


def test_a_gallery_of_nothing_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    (tmp_path / "params.yaml").write_text("{}\n")
    monkeypatch.chdir(tmp_path)
    assert main(["gallery"]) == 1
    assert "no table or figure is made yet" in capsys.readouterr().err
