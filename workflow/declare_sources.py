"""Bring up to date what the engines are told of each step's code and libraries: `make sources`.

dvc.yaml: the source files that a stage's command imports. workflow/versions.yaml: the versions, from requirements.lock,
of the libraries that it computes with; both engines run a step again where one of these changes.
"""

import re
from pathlib import Path

from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.provenance import source_digest
from foggy_synscapes.provenance.runs import DISTRIBUTIONS

SOURCE = re.compile(r"^( *)- src/foggy_synscapes/")
COMMAND = re.compile(r"^ *cmd: foggy (\w+)")
WORDS = ("scenes", "filter", "fog", "subset", "train", "evaluate", "tables", "figures", "stability", "tradeoff")
VERSIONS = Path("workflow/versions.yaml")
# These check params, read YAML and draw progress bars; what a step computes does not pass through them.
NOT_COMPUTING = {"pydantic", "tqdm", "yaml"}


def declare(lines: list[str]) -> list[str]:
    """The lines of dvc.yaml with each block of source files made anew for the command that stands above it."""
    written: list[str] = []
    word = ""
    for number, line in enumerate(lines):
        command, source = COMMAND.match(line), SOURCE.match(line)
        word = command[1] if command else word
        if source is None:
            written.append(line)
        elif SOURCE.match(lines[number - 1]) is None:
            written += [f"{source[1]}- src/foggy_synscapes/{name}" for name in source_digest.sources(word)]
    return written


def versions(lock: str) -> str:
    """The text of workflow/versions.yaml for the text of a lock file.

    Raises KeyError naming a library that a step imports and the lock file lacks.
    """
    locked = {name.lower(): version for name, version in re.findall(r"^([\w.-]+)==([^\s;]+)", lock, re.MULTILINE)}
    lines = [
        "# Versions of the libraries that each step computes with, from requirements.lock; made by `make sources`."
    ]
    for word in WORDS:
        names = [DISTRIBUTIONS.get(name, name) for name in source_digest.libraries(word) if name not in NOT_COMPUTING]
        values = ", ".join(f'{name}: "{locked[name.lower()]}"' for name in names)
        lines.append(f"{word}: {{{values}}}")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    path = Path("dvc.yaml")
    write_text(path, "\n".join(declare(path.read_text(encoding="utf-8").split("\n"))))
    write_text(VERSIONS, versions(Path("requirements.lock").read_text(encoding="utf-8")))
