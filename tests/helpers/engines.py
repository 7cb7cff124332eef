"""Clones of this project in which an engine runs the chain on the smallest params."""

import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

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
