"""What counts of the code of a job: the meaning of the modules that it runs, and the versions of its libraries.

A module counts by its syntax tree without docstrings, comments and layout. Counted are the module of the job's word,
the registered entries that it uses (a network, a dataset, a figure), and what these import. The chassis does not count:
what it decides reaches a job by declared values, and a new key of a figure must train no network.
"""

import ast
import filecmp
import importlib
import sys
from collections.abc import Iterable
from functools import cache
from importlib import metadata
from pathlib import Path

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.hashing import sha256, sha256_bytes
from foggy_synscapes.io.stamps import stamp
from foggy_synscapes.registry import PACKAGE, PLUGINS, Registry, load_plugin, plugin_files

CHASSIS: tuple[str, ...] = (
    "cli",
    "commands",
    "errors",
    "jobs",
    "measured_steps",
    "params",
    "planning",
    "provenance",
    "registry",
    "results",
    "schema",
    "step_files",
    "steps",
    "stereo_steps",
)
CHASSIS += ("io.lock", "io.progress")
"""Modules and packages, below that of the project, whose code is no part of what a job computes."""
CHECKED = ("frames.compositing",)
"""Modules whose results are compared with a recorded hash, so that their code cannot change any."""
NOT_COMPUTING = {"pydantic", "tqdm", "yaml"}
"""Libraries that check params, read YAML and draw progress bars."""
DISTRIBUTIONS = {"PIL": "pillow"}
"""Distributions whose name is not the name that is imported."""
FOLDER = Path(__file__).resolve().parents[1]
STARTED = {path: stamp(path) for path in FOLDER.rglob("*.py")}
"""The sources as this process began: this module is loaded before any that computes."""


def code(word: str, entries: tuple[str, ...], registries: dict[str, Registry]) -> tuple[dict[str, str], dict[str, str]]:
    """What counts of the code of a job: digest by module, e.g. `stages.filter`, and version by library; both sorted.

    word : the job's command; entries : registered entries that it uses, as REGISTRY.NAME

    Raises UnknownEntry if an entry is not registered.
    """
    starts = _files(f"{PACKAGE}.stages.{word}")
    starts += [registries[entry.partition(".")[0]].file(entry.partition(".")[2]) for entry in entries]
    files = _reach(tuple(starts), tuple(plugin_files()))
    digests = {_name(path): _digest(path) for path in files}
    # Numbers and templates beside a package's code belong to it.
    for folder in {path.parent for path in files if path.name == "__init__.py"}:
        for path in (*folder.glob("*.csv"), *folder.glob("templates/*")):
            digests[path.relative_to(FOLDER).as_posix()] = sha256(path)
    imported = {name.partition(".")[0] for path in files for name in _imports(path, _stamp(path))}
    imported -= {PACKAGE, PLUGINS, *sys.stdlib_module_names, *NOT_COMPUTING}
    versions = {DISTRIBUTIONS.get(name, name): version(DISTRIBUTIONS.get(name, name)) for name in imported}
    return dict(sorted(digests.items())), dict(sorted(versions.items()))


def now(name: str) -> str | None:
    """Today's digest of what a record names as code; None where it is gone."""
    if "/" in name:
        path = FOLDER / name
        return sha256(path) if path.is_file() else None
    found = [path for path in _files(_dotted(name)) if _name(path) == name]
    return _digest(found[0]) if found else None


class Loaded:
    """The modules of a job as they are loaded when it starts, so that later edits have no part in it.

    names : as in `code`. Those that need a library which is not loaded are left until they are used: few are.

    Raises FoggyError if one was edited while this process started, so that not all of it may be of one version.
    """

    def __init__(self, names: Iterable[str]) -> None:
        files = {
            name: path for name in names if "/" not in name for path in _files(_dotted(name)) if _name(path) == name
        }
        imports = {name: _imports(path, _stamp(path)) for name, path in files.items()}
        late = {name for name, found in imports.items() if not all(map(_is_at_hand, found))}
        needs = {name: {_name(path) for each in found for path in _files(each)} for name, found in imports.items()}
        while more := {name for name in needs.keys() - late if needs[name] & late}:
            late |= more
        for name in files.keys() - late:
            if name.startswith(f"{PLUGINS}."):
                load_plugin(files[name])
            else:
                importlib.import_module(_dotted(name))
        self.late = {name: files[name] for name in late if _dotted(name) not in sys.modules}
        self._stamps = {name: stamp(path) for name, path in self.late.items()}
        edited = [name for name, path in files.items() if STARTED.get(path, stamp(path)) != stamp(path)]
        if edited:
            raise FoggyError(f"{edited[0]}: its code was edited while this command started. Run it again.")

    def check(self) -> None:
        """Raise FoggyError if a module was edited before it was loaded."""
        for name, path in self.late.items():
            if _dotted(name) in sys.modules and stamp(path) != self._stamps[name]:
                raise FoggyError(
                    f"{name}: its code was edited before this command came to use it, so that it ran part of one and "
                    "part of another version. Nothing of that is kept: run it again."
                )


def _dotted(name: str) -> str:
    return name if name.partition(".")[0] == PLUGINS else f"{PACKAGE}.{name}"


def _is_at_hand(name: str) -> bool:
    top = name.partition(".")[0]
    return top in (PACKAGE, PLUGINS) or top in sys.modules or top in sys.stdlib_module_names


def check_origin(folder: Path = Path()) -> None:
    """Refuse to run code that is not that of the folder in which it runs.

    Equal content from elsewhere is good: an installed package, or another clone as it is here.

    Raises FoggyError naming a file that differs.
    """
    own = (folder / "src" / PACKAGE).resolve()
    if own == FOLDER or not own.is_dir():
        return
    names = {path.relative_to(base) for base in (own, FOLDER) for path in base.rglob("*.py")}
    for name in sorted(names):
        here, loaded = own / name, FOLDER / name
        if not here.is_file() or not loaded.is_file() or not _means_the_same(here, loaded):
            raise FoggyError(
                f"{here.relative_to(folder.resolve())}: differs from {loaded}, which is the code that runs. Run the "
                "`foggy` of this folder: make its environment anew (rm -r .venv; make), or pip install --editable ."
            )


def _means_the_same(one: Path, other: Path) -> bool:
    return filecmp.cmp(one, other, shallow=False) or _digest(one) == _digest(other)


@cache
def version(distribution: str) -> str:
    """Installed version of a distribution, without the local part that names a build of it."""
    try:
        return metadata.version(distribution).partition("+")[0]
    except metadata.PackageNotFoundError:
        return "not installed"


def identity(*found: dict[str, str]) -> str:
    """One SHA-256 for all that counts of a job's code."""
    lines = [f"{name} {value}\n" for values in found for name, value in sorted(values.items())]
    return sha256_bytes("".join(lines).encode())


def _reach(starts: tuple[Path, ...], _plugins: tuple[Path, ...]) -> list[Path]:
    """Source files of the starts and of all that they import, without the chassis."""
    seen: dict[Path, None] = {}
    waiting = list(starts)
    while waiting:
        path = waiting.pop()
        if path in seen or _is_chassis(path):
            continue
        seen[path] = None
        waiting += [found for name in _imports(path, _stamp(path)) for found in _files(name)]
    return sorted(seen)


def _is_chassis(path: Path) -> bool:
    name = _name(path)
    return name == "" or any(name == part or name.startswith(f"{part}.") for part in CHASSIS + CHECKED)


def _name(path: Path) -> str:
    """Dotted name below the project's package, or of a plugin."""
    if not path.is_relative_to(FOLDER):
        return f"{PLUGINS}.{path.stem}"
    parts = path.relative_to(FOLDER).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _files(name: str) -> list[Path]:
    """Source files of an imported name and of the packages around it; none for what is not of this project."""
    top, _, rest = name.partition(".")
    if top == PLUGINS:
        return [path for path in plugin_files() if path.stem == rest.partition(".")[0]]
    if top != PACKAGE:
        return []
    parts, found = rest.split(".") if rest else [], []
    for end in range(1, len(parts) + 1):
        base = FOLDER.joinpath(*parts[:end])
        found += [path for path in (base / "__init__.py", base.with_suffix(".py")) if path.is_file()]
    return found


def _stamp(path: Path) -> tuple[int, ...]:
    return tuple(stamp(path))


@cache
def _imports(path: Path, _changed: tuple[int, ...]) -> frozenset[str]:
    """Dotted names that a file imports, inside functions too; `from a import b` counts as a and a.b."""
    found = set()
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return frozenset(found)


def _digest(path: Path) -> str:
    return _digest_at(path, _stamp(path))


@cache
def _digest_at(path: Path, _changed: tuple[int, ...]) -> str:
    return meaning(path.read_bytes())


def meaning(source: bytes) -> str:
    """SHA-256 of a module's syntax tree without docstrings: comments, line breaks and brackets do not count.

    >>> meaning(b"def f(x):\\n    'Twice.'\\n    return 2 * x  # fast") == meaning(b"def f(x): return (2 * x)")
    True
    >>> meaning(b"x = 1") == meaning(b"x = 1.0")
    False
    """
    tree = ast.parse(source)
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            node.body = [part for part in node.body if not _is_text(part)]
    return sha256_bytes(_dump(tree).encode())


def _is_text(node: ast.stmt) -> bool:
    """A docstring, also one that explains the constant before it."""
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)


def _dump(node: object) -> str:
    """Text of a syntax tree that is the same for every version of Python: empty fields are left out."""
    if isinstance(node, ast.AST):
        fields = ((name, getattr(node, name, None)) for name in node._fields)
        inner = ",".join(f"{name}={_dump(value)}" for name, value in fields if value not in (None, []))
        return f"{type(node).__name__}({inner})"
    if isinstance(node, list):
        return f"[{','.join(map(_dump, node))}]"
    return f"{type(node).__name__}:{node!r}"
