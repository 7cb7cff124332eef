"""Rewrite the source files that each stage of dvc.yaml declares to those that its command imports: `make sources`."""

import re
from pathlib import Path

from foggy_synscapes import closure
from foggy_synscapes.io.atomic import write_text

SOURCE = re.compile(r"^( *)- src/foggy_synscapes/")
COMMAND = re.compile(r"^ *cmd: foggy (\w+)")


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
            written += [f"{source[1]}- src/foggy_synscapes/{name}" for name in closure.sources(word)]
    return written


if __name__ == "__main__":
    path = Path("dvc.yaml")
    write_text(path, "\n".join(declare(path.read_text(encoding="utf-8").split("\n"))))
