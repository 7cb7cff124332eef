"""What is current is judged by content, whoever made it, and a job is of one version of its code, params and inputs."""

import json
import os
import re
import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import tiny_chain
import tiny_engines
from dvc.lock import LockError, make_lock

from foggy_synscapes.datasets.index import changed_since_listed
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io import lock
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.stamps import Stamps, stamp
from foggy_synscapes.provenance import source_digest
from foggy_synscapes.provenance.check import verify
from foggy_synscapes.provenance.current import changed_raw_data, out_of_date, raw_data_in_words
from foggy_synscapes.provenance.runs import PLANNED, params_digest, read_run
from foggy_synscapes.stages.clean import remove, unused
from foggy_synscapes.standin.drawing import Made
from foggy_synscapes.steps import all_jobs

TRAIN = "train --seed 0"
MODEL = Path("results/train/0/model.txt")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder in which the tiny chain ran."""
    monkeypatch.chdir(tmp_path)
    tiny_chain.start(tmp_path)
    with tiny_chain.installed():
        tiny_engines.snakemake()
        assert stale() == []
        yield tmp_path


def stale() -> list[str]:
    return [tiny_engines.name(again.node.job) for again in out_of_date(tiny_chain.params_here())]


def job(name: str):  # type: ignore[no-untyped-def]
    return next(job for job in all_jobs(tiny_chain.params_here()) if tiny_engines.name(job) == name)


def edit(path: str | Path, text: str, times: bool = False) -> None:
    """Edit a file; with `times` it keeps its own, as after `rsync -a`, `tar` or `cp -p`."""
    status = Path(path).stat()
    Path(path).write_text(text)
    if times:
        os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))


def other_params(**values: object) -> None:
    edit("params.yaml", json.dumps(tiny_chain.changed(json.loads(Path("params.yaml").read_text()), **values)), True)


# Which code, params and inputs ran.


def test_code_of_another_folder_is_refused_and_equal_code_is_good(tmp_path: Path) -> None:
    own = tmp_path / "src/foggy_synscapes"
    shutil.copytree(source_digest.FOLDER, own, ignore=shutil.ignore_patterns("__pycache__"))
    source_digest.check_origin(tmp_path)
    with open(own / "camera.py", "a") as file:
        file.write("# A comment.\n")
    source_digest.check_origin(tmp_path)
    with open(own / "fog/optics.py", "a") as file:
        file.write("FACTOR = 2\n")
    with pytest.raises(FoggyError, match=r"^src/foggy_synscapes/fog/optics\.py: differs from .*pip install --editable"):
        source_digest.check_origin(tmp_path)
    (own / "fog/optics.py").unlink()
    with pytest.raises(FoggyError, match=r"fog/optics\.py: differs"):
        source_digest.check_origin(tmp_path)


def test_a_job_that_was_planned_with_other_params_does_not_run(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(PLANNED, params_digest(tiny_chain.params_here()))
    other_params(stability__digits=40)
    before = MODEL.read_bytes()
    with pytest.raises(FoggyError, match="the params were edited after this run was planned"):
        tiny_chain.run(job(TRAIN))
    assert MODEL.read_bytes() == before


def test_a_job_whose_input_changes_meanwhile_fails_and_is_out_of_date(folder: Path) -> None:
    change = {"half": lambda: edit(tiny_chain.WEIGHTS, "v", True)}
    with pytest.raises(FoggyError, match=r"^weights\.txt: was changed while .*train --seed 0 read it"):
        tiny_chain.run(job(TRAIN), change)
    assert TRAIN in stale()


def test_code_that_is_edited_meanwhile_leaves_the_output_under_its_own_identity(folder: Path, capsys) -> None:
    identity = source_digest.meaning(b"VALUE = 0")
    tiny_chain.run(job(TRAIN), {"half": lambda: edit("toy/train.py", "VALUE = 1")})
    assert "of the code as it was, and out of date" in capsys.readouterr().err
    assert read_run(MODEL.with_name("run.json"))["code"] == {"toy/train.py": identity}
    assert stale() == [TRAIN, *(name for name in stale() if name.startswith("tables"))]


def test_an_output_that_something_else_changes_before_its_record_fails_the_job(folder: Path) -> None:
    before = MODEL.with_name("run.json").read_bytes()
    with pytest.raises(FoggyError, match=r"model\.txt: was changed by something else while .*train --seed 0 ran"):
        tiny_chain.run(job(TRAIN), {"unrecorded": lambda: edit(MODEL, "x" * len(MODEL.read_text()), True)})
    assert MODEL.with_name("run.json").read_bytes() == before
    assert TRAIN in stale()


# What is current.

CHANGES: dict[str, tuple[Callable[[], None], str]] = {
    "code": (lambda: edit("toy/train.py", "VALUE = 5", True), TRAIN),
    "params": (lambda: other_params(stability__digits=40), TRAIN),
    "weights by an older file": (lambda: edit(tiny_chain.WEIGHTS, "v", True), TRAIN),
    "an output": (lambda: edit(MODEL, "x", True), TRAIN),
    "a record": (lambda: edit(MODEL.with_name("run.json"), "{}", True), TRAIN),
}


@pytest.mark.parametrize("what", CHANGES)
def test_an_edit_with_an_old_time_is_seen_and_mended_by_the_normal_command(folder: Path, what: str) -> None:
    change, first = CHANGES[what]
    change()
    for path in Path("results").rglob("*"):  # as `snakemake --touch` leaves them
        os.utime(path, (2_000_000_000,) * 2)
    assert first in stale()
    tiny_engines.snakemake()
    assert stale() == []


@pytest.mark.parametrize("gone", [lambda index: index.unlink(), lambda index: edit(index, "path,size,sha256\n", True)])
def test_raw_files_are_looked_at_where_their_index_is_gone(folder: Path, gone: Callable[[Path], None]) -> None:
    index = Path(tiny_chain.INDEX)
    gone(index)
    assert "fog --shard 0000" not in stale()  # it comes out as it was
    edit("raw/a.txt", "z", True)
    assert {"scenes --dataset synscapes", "fog --shard 0000", TRAIN} <= {*stale()}
    tiny_engines.snakemake()
    assert stale() == []
    assert "z" in Path("results/fog/0000.tar").read_text()


def test_a_missing_file_waits_for_the_altered_one_that_it_is_made_of(folder: Path) -> None:
    table, before = Path("results/tables/foggy_driving.csv"), MODEL.read_bytes()
    edit(MODEL, "x")
    table.unlink()
    found = {
        tiny_engines.name(again.node.job): again.alone
        for again in out_of_date(tiny_chain.params_here(), asked=[str(table)])
    }
    assert found == {TRAIN: True, "tables --test-set foggy_driving": True}
    tiny_engines.snakemake()
    assert MODEL.read_bytes() == before
    assert table.is_file()


def test_results_of_another_clone_and_of_a_job_run_by_hand_are_compared(folder: Path, tmp_path: Path) -> None:
    kept = Path("params.yaml").read_text()
    other_params(stability__digits=40)
    tiny_chain.run(job(TRAIN))
    edit("params.yaml", kept, True)
    assert TRAIN in stale()


def test_a_comment_a_touch_and_a_copied_folder_run_nothing(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    edit("toy/train.py", "VALUE = 0  # why")
    edit("params.yaml", Path("params.yaml").read_text() + "\n")
    for path in Path("results").rglob("*"):
        path.touch()
    assert stale() == []
    for times in (True, False):
        monkeypatch.chdir(tiny_chain.copied(folder, folder.with_name(f"copy {times}"), times))
        assert stale() == []
        assert tiny_engines.snakemake().jobs == []


def test_an_altered_output_is_made_again_alone(folder: Path) -> None:
    edit("results/fog/0000.csv", "altered", True)
    assert stale() == ["fog --shard 0000"]
    assert tiny_engines.snakemake().jobs == ["fog --shard 0000"]
    assert tiny_engines.snakemake().jobs == []


def test_what_was_removed_whole_to_save_space_stays_away_until_a_job_needs_it(folder: Path) -> None:
    shutil.rmtree("results/fog")
    assert tiny_engines.snakemake().jobs == []
    edit("toy/train.py", "VALUE = 1")
    assert tiny_engines.snakemake().jobs[0] == "fog --shard 0000"


def test_the_second_look_reads_nothing(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for path in Path("results").rglob("*"):
        if path.is_file():
            os.utime(path, (1_700_000_000,) * 2)
    monkeypatch.setattr("foggy_synscapes.io.stamps.SETTLED_NS", -1)
    monkeypatch.setattr("foggy_synscapes.io.stamps.COARSE_NS", -1)
    assert stale() == []
    monkeypatch.setattr(Stamps, "take", lambda self, file: pytest.fail(f"{file} was read"))
    assert stale() == []


# Raw data.


def test_raw_data_that_is_edited_in_place_is_seen_and_listing_it_mends_it(folder: Path) -> None:
    edit("raw/a.txt", "z", True)
    first = job("scenes --dataset synscapes")
    assert changed_raw_data(first) == [Path("raw/a.txt")]
    tiny_chain.run(first)
    assert changed_raw_data(first) == []
    assert "fog --shard 0000" in stale()


def test_a_dataset_that_is_not_mounted_is_no_list_of_changes(folder: Path) -> None:
    first = job("scenes --dataset synscapes")
    changed = [Path("raw/a.txt")]
    told = raw_data_in_words(first, changed, " --params params/smoke.yaml")
    assert told.startswith("1 files are not as they were listed, first raw/a.txt. Run `")
    assert "scenes --dataset synscapes --params params/smoke.yaml`" in told
    os.rename("raw", "unmounted")
    assert changed_raw_data(first) != []
    told = raw_data_in_words(first, changed_raw_data(first))
    assert told.startswith("scenes.roots.synscapes: raw does not exist, though its files were listed before.")


def test_raw_data_that_was_copied_or_touched_refreshes_its_stamp_alone(folder: Path) -> None:
    index, known = Path(tiny_chain.INDEX), stamp("raw/a.txt")
    shutil.copytree("raw", "elsewhere")
    shutil.rmtree("raw")
    os.rename("elsewhere", "raw")
    assert stamp("raw/a.txt") != known
    assert changed_since_listed(index, Path("raw")) == []
    assert stale() == []
    assert not list(Path("results").rglob("*stamps*"))


def test_verify_hashes_raw_data_where_it_is_asked_to(folder: Path) -> None:
    edit("raw/a.txt", "z", True)
    verify(Path("results"))
    with pytest.raises(FoggyError, match=r"raw/a\.txt: changed \(listed in results/scenes/index/synscapes/all\.csv\)"):
        verify(Path("results"), {"synscapes": Path("raw")})


def test_a_drawn_frame_that_is_edited_in_place_is_drawn_again_and_a_copied_one_is_not(tmp_path: Path) -> None:
    for name in ("a.png", "b.png"):
        (tmp_path / name).write_text(name)
    made = Made(tmp_path / "frames.json", "by this code", tmp_path)
    made.add(["a.png", "b.png"])
    made.save()
    edit(tmp_path / "a.png", "A.png", True)
    shutil.copy(tmp_path / "b.png", tmp_path / "c.png")
    os.replace(tmp_path / "c.png", tmp_path / "b.png")
    again = Made(tmp_path / "frames.json", "by this code", tmp_path)
    assert not again.has(["a.png"])
    assert again.has(["b.png"])


# What nobody asks for any more; two engines.


def test_what_is_not_asked_for_any_more_is_listed_and_removed(folder: Path) -> None:
    assert unused(tiny_chain.params_here()) == []
    other_params(evaluate__test_sets=["foggy_driving"])
    found = unused(tiny_chain.params_here())
    dropped = [
        f"results/tables/{name}.{ending}" for name in ("cityscapes", "foggy_zurich") for ending in ("csv", "run.json")
    ]
    assert [str(path) for path in found] == dropped
    remove(found)
    assert not any(path.exists() for path in found)
    assert Path("results/tables/foggy_driving.csv").is_file()
    assert stale() == []


def test_while_snakemake_works_dvc_gets_no_lock(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path(".dvc/tmp").mkdir(parents=True)
    own = make_lock(".dvc/tmp/lock", tmp_dir=".dvc/tmp")
    with lock.hold(against_dvc=True), pytest.raises(LockError):
        own.lock()
    own.lock()
    with pytest.raises(FoggyError, match="another run is at work"):
        lock.hold(against_dvc=True)
    own.unlock()
    lock.hold(against_dvc=True).close()


# The model of the engine is the engine.


def test_snakemake_plans_what_is_modelled(folder: Path) -> None:
    call = tiny_chain.snakefile(folder)
    edit("toy/train.py", "VALUE = 5", True)
    edit("results/fog/0000.csv", "altered", True)
    Path("results/tables/foggy_zurich.csv").unlink()
    told = subprocess.run([*call, "--dry-run"], capture_output=True, text=True, check=True)
    plan = re.findall(r"^Shell command: .*tiny_chain\.py (.*?) (?:--params|>)", told.stdout + told.stderr, re.MULTILINE)
    assert sorted(plan) == sorted(set(stale()))
    assert "fog --shard 0000" in plan
    subprocess.run(call, capture_output=True, text=True, check=True)
    assert stale() == []
    told = subprocess.run([*call, "--dry-run"], capture_output=True, text=True, check=True)
    assert "Nothing to be done" in told.stdout + told.stderr
    write_text("params.yaml", Path("params.yaml").read_text())
