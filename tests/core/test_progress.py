"""What a log says while something long goes on, and what is shown of the log of a job that failed."""

import subprocess
import sys
import time
from pathlib import Path

import pytest

from foggy_synscapes.io.progress import Progress
from foggy_synscapes.io.reasons import LINES, reasons
from foggy_synscapes.io.tables import GrowingTable, read_csv

SAID = "Command 'set -euo pipefail;  foggy train --row C > {} 2>&1' returned non-zero exit status 1.\n"


def test_a_log_has_lines_with_speed_and_time_left(
    capsys: pytest.CaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = iter([0, 10, 20, 21, 50, 100])
    monkeypatch.setattr(time, "monotonic", lambda: next(clock))
    bar = Progress("train", 1000, done=100)
    for done in (100, 200, 210, 500, 1000):
        bar.update(done, loss="0.5")
    assert capsys.readouterr().err.splitlines() == [
        "train: 100 of 1,000 images, loss 0.5, 0 images/s, unknown left",
        "train: 200 of 1,000 images, loss 0.5, 5 images/s, 0:02:40 left",
        "train: 500 of 1,000 images, loss 0.5, 8 images/s, 0:01:02 left",
        "train: 1,000 of 1,000 images, loss 0.5, 9 images/s, 0:00:00 left",
    ]


def test_each_row_of_a_growing_table_is_on_disk_at_once(tmp_path: Path) -> None:
    path = tmp_path / "logs/curves.csv"
    table = GrowingTable(path, ("step", "loss"))
    for number in (1, 2):
        table.add([number, None])
        assert len(read_csv(path, ("step", "loss"))) == number
    table.close()


def test_the_end_of_a_failed_jobs_log_is_shown_and_no_other(tmp_path: Path) -> None:
    failed, good, cluster = (tmp_path / name for name in ("it failed.log", "good.log", "cluster.log"))
    failed.write_text("".join(f"line {number}\n" for number in range(40)) + "bar 1\rbar 2\nfoggy train: no such file\n")
    good.write_text("all is well\n")
    cluster.write_text("")
    own = tmp_path / "snakemake.log"
    own.write_text(
        f"    log: {good}\n{SAID.format(repr(str(failed)))}    log: {cluster} (check log file(s) for error details)\n"
    )
    first, second = reasons([str(own), str(tmp_path / "gone")])
    assert first.startswith(f"{failed}:\n    line 27\n")
    assert first.endswith("    bar 2\n    foggy train: no such file")
    assert len(first.splitlines()) == LINES + 1
    assert second == f"{cluster}:\n    (says nothing: the job was killed)"


def test_the_first_compilation_is_told_once_and_what_is_kept_says_nothing(tmp_path: Path) -> None:
    (tmp_path / "loops.py").write_text(
        "from foggy_synscapes.jit import jit\n"
        "def one(x):\n    return x + 1\n"
        "def two(x):\n    return x + 2\n"
        "first, second = jit(one), jit(two)\n"
    )
    said = [
        subprocess.run(
            [sys.executable, "-c", "import loops; print(loops.first(1) + loops.second(1))"],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=True,
        )
        for _ in range(2)
    ]
    assert [each.stdout for each in said] == ["5\n", "5\n"]
    assert [each.stderr.count("compiling what this needs") for each in said] == [1, 0]
