"""verify --rebuild: jobs are done again beside their results; what comes out otherwise is named, with the reasons."""

import json
from pathlib import Path

import pytest
from records import vouch

from foggy_synscapes.cli import main
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.hashing import sha256
from foggy_synscapes.io.tables import write_csv
from foggy_synscapes.params import load, resolved

ROOT = Path(__file__).resolve().parents[2]
COLUMNS = ("path", "size", "sha256")
LIST = Path("results/subset/C/train.csv")
RECORD = LIST.with_name("run.json")


@pytest.fixture(autouse=True)
def listed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A list of one training and one validation frame, made by `foggy subset`."""
    monkeypatch.chdir(tmp_path)
    document = resolved.document(load(ROOT / "params/smoke.yaml"))
    document["subset"]["clear"]["C"] = {"train": 1, "validation": 1}
    write_text("params.yaml", json.dumps(document))
    paths = [
        f"{kind}/{split}/{city}/{city}_000000_000019_{kind}{ending}.png"
        for split, city in (("train", "aachen"), ("val", "ulm"))
        for kind, ending in (("leftImg8bit", ""), ("gtFine", "_labelIds"))
    ]
    write_csv("results/scenes/index/cityscapes/all.csv", COLUMNS, [(path, 1, "0" * 64) for path in sorted(paths)])
    vouch()
    assert main(["subset", "--row", "C"]) == 0


def rebuilt(capsys: pytest.CaptureFixture, status: int) -> str:
    capsys.readouterr()
    assert main(["verify", "results/subset", "--rebuild", "subset"]) == status
    told = capsys.readouterr()
    assert "Traceback" not in told.err
    assert {path.name for path in Path(".foggy").iterdir()} == {"cache", "jobs", "lock"}
    return told.out + told.err


def edited(**values: object) -> None:
    write_text(RECORD, json.dumps({**json.loads(RECORD.read_text()), **values}))


def test_the_same_code_gives_the_same_bytes_and_leaves_no_trace(capsys: pytest.CaptureFixture) -> None:
    before = {path: path.stat().st_mtime_ns for path in Path("results").rglob("*")}
    told = rebuilt(capsys, 0)
    assert told == "foggy subset --row C: the same\nverify: 2 files come out as they are\n"
    assert {path: path.stat().st_mtime_ns for path in Path("results").rglob("*")} == before


def test_what_comes_out_otherwise_is_named_and_not_replaced(capsys: pytest.CaptureFixture) -> None:
    write_text(LIST, LIST.read_text() + "\n")
    altered = sha256(LIST)
    told = rebuilt(capsys, 1)
    assert f"foggy subset --row C: DIFFERENT: {LIST}\n" in told
    assert "1 of 2 files come out otherwise" in told
    assert sha256(LIST) == altered


def test_another_instruction_set_version_or_code_is_told(capsys: pytest.CaptureFixture) -> None:
    record = json.loads(RECORD.read_text())
    edited(
        instructions={"machine": "riscv64", "extensions": record["instructions"]["extensions"] + " RVV"},
        versions={**record["versions"], "python": "2.7"},
        code={**record["code"], "stages.subset": "0" * 64},
    )
    told = rebuilt(capsys, 0)
    assert "instruction set: extensions was with RVV, is without" in told
    assert "instruction set: machine was with riscv64, is without; without" in told
    assert "python was 2.7, is" in told
    assert "code changed since: stages.subset" in told


@pytest.mark.parametrize(
    "command",
    [
        ["foggy", "subset", "--row", "C", "--debug"],
        ["foggy", "subset", "--params=/etc/passwd"],
        ["touch", "subset", "x"],
    ],
)
def test_a_record_whose_command_is_no_job_is_not_run(command: list, capsys: pytest.CaptureFixture) -> None:
    edited(command=command)
    assert "is no job of foggy subset; not run" in rebuilt(capsys, 1)


def test_a_record_whose_command_is_no_list_of_words_is_no_record(capsys: pytest.CaptureFixture) -> None:
    edited(command=["foggy", "subset", 1])
    assert "the command is no list of words" in rebuilt(capsys, 1)


def test_a_record_whose_input_leaves_the_folder_is_not_followed(capsys: pytest.CaptureFixture) -> None:
    record = json.loads(RECORD.read_text())
    edited(inputs={**record["inputs"], "results/subset/../../../../notes.txt": "0" * 64})
    Path("notes.txt").write_text("mine")
    assert "its input results/subset/../../../../notes.txt leaves the folder" in rebuilt(capsys, 1)
    assert Path("notes.txt").read_text() == "mine"


def test_a_step_without_jobs_there_is_said(capsys: pytest.CaptureFixture) -> None:
    assert main(["verify", "--rebuild", "fog"]) == 1
    assert "no run record of foggy fog speaks of it" in capsys.readouterr().err
    assert main(["verify", "--rebuild", "unpack"]) == 2
