"""Which source files a command runs: its module and everything of this package that this module imports.

Both engines list these files as inputs, so that an edit re-runs what it can change and nothing else.
The files are parsed, not imported: imports inside functions count too.
"""

import ast
import sys
from functools import cache
from pathlib import Path

PACKAGE = "foggy_synscapes"
CHECKED = {("stages/train.py", "frames"), ("stages/train.py", "frames.recipes")}
"""Imports whose edit re-runs nothing here: a recipe holds the hash of the pixels that have to come out."""
FOLDER = Path(__file__).resolve().parents[1]


def sources(word: str) -> list[str]:
    """Source files of a command, relative to the package's folder, sorted; e.g. `stages/filter.py`.

    The tables of numbers that lie beside a package's code belong to it.
    """
    files = _reach(f"stages.{word}")
    packages = {(FOLDER / file).parent for file in files if file.endswith("__init__.py")}
    data = {path.relative_to(FOLDER).as_posix() for package in packages for path in package.glob("*.csv")}
    return sorted(files | data)


def libraries(word: str) -> list[str]:
    """Top-level names of the third-party modules that a command's sources import, sorted."""
    names = set().union(*(_imports(file)[1] for file in _reach(f"stages.{word}")))
    return sorted(names - set(sys.stdlib_module_names) - {PACKAGE})


@cache
def _reach(start: str) -> frozenset[str]:
    seen: set[str] = set()
    parts = start.split(".")
    waiting = [".".join(parts[:end]) for end in range(len(parts) + 1)]
    while waiting:
        file = _file(waiting.pop())
        if file is not None and file not in seen:
            seen.add(file)
            waiting += sorted(module for module in _imports(file)[0] if (file, module) not in CHECKED)
    return frozenset(seen)


def _file(module: str) -> str | None:
    """Source file of a module named relative to the package, or None where the name is not a module."""
    base = FOLDER.joinpath(*module.split(".")) if module else FOLDER
    for path in (base / "__init__.py", base.with_suffix(".py")):
        if path.is_file():
            return path.relative_to(FOLDER).as_posix()
    return None


@cache
def _imports(file: str) -> tuple[frozenset[str], frozenset[str]]:
    """Modules of this package (relative names, with the packages around them) and other top-level names."""
    own, other = set(), set()
    for node in ast.walk(ast.parse((FOLDER / file).read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            # `from package import name`: the name may be a module or something inside one.
            names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)] if node.module else []
        else:
            continue
        for name in names:
            top, _, rest = name.partition(".")
            if top == PACKAGE:
                parts = rest.split(".") if rest else []
                own.update(".".join(parts[:end]) for end in range(len(parts) + 1))
            else:
                other.add(top)
    return frozenset(own), frozenset(other)
