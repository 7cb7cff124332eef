"""What is edited in place does not reach through into DVC's cache."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_a_result_that_is_edited_in_place_leaves_the_cache_as_it_was(tmp_path: Path) -> None:
    def dvc(*arguments: str) -> None:
        subprocess.run([sys.executable, "-m", "dvc", *arguments], cwd=tmp_path, check=True, capture_output=True)

    dvc("init", "--no-scm")
    (tmp_path / ".dvc/config").write_text(
        (ROOT / ".dvc/config").read_text().replace("[core]", "[core]\n    no_scm = true")
    )
    result = tmp_path / "table.csv"
    result.write_bytes(b"miou\n71.3\n")
    dvc("add", "table.csv")
    with open(result, "r+b") as file:
        file.write(b"MIOU")
    (cached,) = [path for path in (tmp_path / ".dvc/cache/files").rglob("*") if path.is_file()]
    assert cached.read_bytes() == b"miou\n71.3\n"
