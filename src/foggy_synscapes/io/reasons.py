"""Why jobs of Snakemake failed: the ends of their logs."""

import re
import shlex
from collections.abc import Iterable, Iterator
from pathlib import Path

LINES = 15
"""Of a log that are shown: a command says why it failed in its last lines, a traceback takes a few more."""
FAILED = re.compile(
    # What Snakemake says of a command that failed here, and of a job that failed here or on a cluster.
    r"^Command '.* > (?P<quoted>.+) 2>&1' (?:returned|died)|^ +log: (?P<names>.+?) \(check log file",
    re.MULTILINE,
)


def reasons(logs: Iterable[str]) -> list[str]:
    """The end of the log of each job that failed, headed by its path; none where Snakemake does not name it.

    logs : files that Snakemake itself logs to
    """
    text = "".join(Path(log).read_text(encoding="utf-8", errors="replace") for log in logs if Path(log).is_file())
    names = (name for match in FAILED.finditer(text) for name in _names(match))
    return [f"{name}:\n{_end(Path(name))}" for name in dict.fromkeys(names)]


def _names(match: re.Match) -> Iterator[str]:
    yield from shlex.split(match["quoted"]) if match["quoted"] else match["names"].split(", ")


def _end(path: Path) -> str:
    # As bytes, or a carriage return would become a line's end.
    text = path.read_bytes().decode("utf-8", errors="replace").rstrip() if path.is_file() else ""
    # A progress bar draws over itself: what it showed last is behind the last carriage return.
    lines = [line.rstrip().rpartition("\r")[2] for line in text.split("\n")]
    return "\n".join(f"    {line}" for line in lines[-LINES:]) if text else "    (says nothing: the job was killed)"
