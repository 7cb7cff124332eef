"""Going from one engine to the other: nothing is made again, and what is stale or altered is not certified."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from engines import ROOT, complete, hashes, planned, run

from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.plain_yaml import read_yaml

METRICS = Path("results/evaluate/foggy_zurich/bisenet/C/seed-0/metrics.json")


def copied(source: Path, target: Path) -> Path:
    """A clone with its results, which a test may change."""
    shutil.copytree(source, target, symlinks=True)
    for name in ("params.yaml", "params/smoke.yaml"):
        write_text(target / name, complete(target / "params/smoke.yaml"))
    if not (target / ".git").exists():
        subprocess.run(["git", "init", "--quiet"], cwd=target, check=True)
    return target


def refused(folder: Path, *arguments: str) -> str:
    """The message with which `foggy adopt` refuses."""
    call = [sys.executable, "-m", "foggy_synscapes", "adopt", *arguments]
    result = subprocess.run(call, cwd=folder, capture_output=True, text=True, check=False)
    assert result.returncode in (1, 2), result.stdout + result.stderr
    assert "Traceback" not in result.stderr
    return result.stderr


def test_after_snakemake_dvc_has_nothing_to_do_and_neither_has_snakemake(snakemake: Path, tmp_path: Path) -> None:
    folder = copied(snakemake, tmp_path / "a clone")
    before = hashes(folder)
    smoke = ("--params", "params/smoke.yaml")
    assert "dvc repro has nothing to do now" in run(folder, "foggy_synscapes", "adopt", "--from", "snakemake", *smoke)
    assert "Data and pipelines are up to date" in run(folder, "dvc", "status")
    told = run(folder, "snakemake", "--dry-run", "--cores", "1", "--configfile", "params/smoke.yaml")
    assert "Nothing to be done" in told
    assert hashes(folder) == before


def test_equal_lists_that_dvc_keeps_as_one_file_do_not_stop_the_next_change_of_params(
    snakemake: Path, tmp_path: Path
) -> None:
    """DVC's cache holds equal files once, and links to it: the time of one then is that of another job's output."""
    folder = copied(snakemake, tmp_path / "clone")
    smoke = ("--params", "params/smoke.yaml")
    run(folder, "dvc", "config", "cache.type", "hardlink")
    call = [sys.executable, "-m", "foggy_synscapes", "adopt", "--from", "snakemake", *smoke]
    told = subprocess.run(call, cwd=folder, capture_output=True, text=True, check=True)
    assert "adopt: dvc commit --force --quiet ..." in told.stderr
    run(folder, "dvc", "checkout", "--relink")
    lists = [folder / f"results/subset/{row}/validation.csv" for row in ("FS-24500", "FS-498")]
    assert len({path.stat().st_ino for path in lists}) == 1
    for name in ("params.yaml", "params/smoke.yaml"):
        document = read_yaml(folder / name)
        document["fog"]["betas"] = ["0.02"]
        for kind in ("pure", "mixed"):
            for row in document["subset"][kind].values():
                row["beta"] = "0.02"
        (folder / name).unlink()  # may be a link, too
        write_text(folder / name, json.dumps(document))
    assert {"fog 0.02 0000", "train bisenet FS-498 0", "tables foggy_zurich"} <= set(planned(folder))


def test_what_dvc_made_with_other_params_is_made_anew_and_not_certified(dvc: Path, tmp_path: Path) -> None:
    """Snakemake has no record of these jobs, and their files are newer than what they were made of."""
    folder = copied(dvc, tmp_path / "clone")
    shutil.rmtree(folder / ".snakemake", ignore_errors=True)
    for name in ("params.yaml", "params/smoke.yaml"):
        text = (folder / name).read_text()
        (folder / name).write_text(text.replace("learning_rate: 0.001\n", "learning_rate: 0.003\n"))
    assert "Snakemake still has work to do" in refused(folder, "--from", "snakemake")
    assert {"train bisenet FC-498 0", "tables foggy_zurich"} <= set(planned(folder))
    assert "train bisenet C 0" not in planned(folder)


def test_what_snakemake_made_it_makes_anew_when_params_change(snakemake: Path, tmp_path: Path) -> None:
    folder = copied(snakemake, tmp_path / "clone")
    params = folder / "params/smoke.yaml"
    params.write_text(params.read_text().replace("learning_rate: 0.001\n", "learning_rate: 0.003\n"))
    assert {"train bisenet FC-498 0", "tables foggy_zurich"} <= set(planned(folder))


def test_after_dvc_snakemake_has_nothing_to_do_until_a_param_changes(dvc: Path, tmp_path: Path) -> None:
    folder = copied(dvc, tmp_path / "clone")
    shutil.rmtree(folder / ".snakemake", ignore_errors=True)
    before = hashes(folder)
    assert "snakemake has nothing to do now" in run(folder, "foggy_synscapes", "adopt", "--from", "dvc")
    assert hashes(folder) == before
    params = folder / "params.yaml"
    params.write_text(params.read_text().replace("maximum: 5.0", "maximum: 5.5"))
    # What is stale now is certified in neither direction; Snakemake sees the change though it ran none of the jobs.
    message = refused(folder, "--from", "dvc")
    assert "DVC does not call everything up to date" in message
    assert "filter: filter modified" in message
    message = refused(folder, "--from", "snakemake")
    assert "Snakemake still has work to do" in message
    assert re.search(r"^filter +1$", message, re.MULTILINE)
    assert not re.search(r"^scenes_synscapes ", message, re.MULTILINE)
    assert "Run snakemake --cores 2 first" in message


def test_altered_results_and_images_are_not_certified(snakemake: Path, tmp_path: Path) -> None:
    folder = copied(snakemake, tmp_path / "clone")
    image = next((folder / "results/scenes/foggy_zurich/RGB").rglob("*.png"))
    for path in (folder / METRICS, image):
        status = path.stat()
        path.write_bytes(path.read_bytes()[:-1] + b" ")
        os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))  # so that Snakemake does not see it
    message = refused(folder, "--from", "snakemake", "--params", "params/smoke.yaml")
    assert f"{METRICS}: changed (recorded in {METRICS.with_name('run.json')})" in message
    assert f"{image.relative_to(folder)}: changed (listed in results/scenes/index/foggy_zurich/all.csv)" in message
    assert not (folder / "dvc.lock").exists()


def test_another_params_file_than_dvc_reads_is_refused(tmp_path: Path) -> None:
    for name in ("Snakefile", "dvc.yaml"):
        (tmp_path / name).write_text("")
    shutil.copy(ROOT / "params.yaml", tmp_path)
    (tmp_path / "other.yaml").write_text("figures: {images: 1}")
    message = refused(tmp_path, "--from", "snakemake", "--params", "other.yaml")
    assert "foggy params --file other.yaml --out params.yaml" in message


def test_params_that_leave_values_to_the_defaults_are_not_what_dvc_reads(tmp_path: Path) -> None:
    for name in ("Snakefile", "dvc.yaml"):
        (tmp_path / name).write_text("")
    (tmp_path / "params.yaml").write_text("figures: {images: 1}")
    message = refused(tmp_path, "--from", "snakemake")
    assert "leaves plugins to the packaged defaults" in message
    assert "foggy params --file params.yaml --out params.yaml" in message


def test_outside_of_a_project_it_says_where_to_run(tmp_path: Path) -> None:
    message = refused(tmp_path, "--from", "dvc")
    assert "no Snakefile, dvc.yaml, params.yaml here. Run foggy adopt in the project's folder" in message
