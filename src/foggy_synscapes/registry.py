"""Registries: what grows is found, not listed. An entry is a module that declares one, here or among the plugins.

A module of a registry's package registers itself by assigning the registry's constant, `NETWORK = NetworkEntry(...)`;
its file's name is the entry's name. Plugins are modules in a folder of the user's that do the same; see `use_plugins`.
"""

import importlib
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Generic, TypeVar

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.files import read_bytes

PACKAGE = "foggy_synscapes"
PLUGINS = "foggy_plugins"
"""Package under whose name the modules of the plugin folder are imported."""
FOLDER = Path(__file__).resolve().parent
LARGEST_MODULE = 1 << 20  # bytes
NAME = re.compile(r"[a-z][a-z0-9_]*")

Entry = TypeVar("Entry")


class UnknownEntry(FoggyError):
    """A name that nothing registered; the message lists those that are."""


class Registry(Generic[Entry]):
    """The entries of one kind, in the order of their names.

    package : package of this project that holds the built-in ones, e.g. "networks"
    constant : what a module assigns to register, e.g. "NETWORK"
    what : a word for messages, e.g. "network"
    """

    def __init__(self, package: str, constant: str, what: str) -> None:
        self.package, self.constant, self.what = package, constant, what
        self._declaration = re.compile(rf"^{constant}\b[^=\n]*= ", re.MULTILINE)

    def names(self) -> list[str]:
        """Names of all entries, sorted. No entry is imported for it."""
        return sorted(self._files())

    def file(self, name: str) -> Path:
        """Source file of an entry; raises UnknownEntry if there is none of this name."""
        files = self._files()
        if name not in files:
            raise UnknownEntry(f"{name!r} is no {self.what}; there are {', '.join(sorted(files))}")
        return files[name]

    def __getitem__(self, name: str) -> Entry:
        """The entry of a name; raises UnknownEntry as `file` does, FoggyError if a plugin cannot be imported."""
        path = self.file(name)
        if path.is_relative_to(FOLDER):
            module = importlib.import_module(".".join((PACKAGE, *path.relative_to(FOLDER).with_suffix("").parts)))
        else:
            module = load_plugin(path)
        return getattr(module, self.constant)

    def __contains__(self, name: object) -> bool:
        return name in self._files()

    def __iter__(self) -> Iterator[str]:
        return iter(self.names())

    def _files(self) -> dict[str, Path]:
        folder = FOLDER.joinpath(*self.package.split("."))
        own = {path.stem: path for path in sorted(folder.glob("*.py")) if self._declares(path)}
        added = {path.stem: path for path in plugin_files() if self._declares(path)}
        both = sorted(own.keys() & added.keys())
        if both:
            raise FoggyError(f"{added[both[0]]}: there is a {self.what} of this name already. Rename the file.")
        return own | added

    def _declares(self, path: Path) -> bool:
        text = read_bytes(path, "Python module", limit=LARGEST_MODULE).decode("utf-8", "replace")
        return self._declaration.search(text) is not None


_plugins: list[Path] = []


def use_plugins(folder: str | Path | None) -> None:
    """Let registries find the modules of a folder too, instead of those of the folder named before.

    Nothing is imported before an entry is asked for. Raises FoggyError if there is no such folder, or a file in it has
    a name that cannot be an entry's.
    """
    chosen = [] if folder is None else [Path(folder).resolve()]
    for path in chosen:
        if not path.is_dir():
            raise FoggyError(f"plugins: {folder} is no folder. Name the folder of your own modules, or null for none.")
        odd = [each.name for each in path.glob("*.py") if NAME.fullmatch(each.stem) is None]
        if odd:
            raise FoggyError(f"plugins: {path / odd[0]}: a plugin's file is named like my_network.py, in small letters")
    if chosen == _plugins:
        return
    _plugins[:] = chosen
    for name in [name for name in sys.modules if name.partition(".")[0] == PLUGINS]:
        del sys.modules[name]


def plugin_files() -> list[Path]:
    """Modules of the plugin folder, sorted by name."""
    return [path for folder in _plugins for path in sorted(folder.glob("*.py"))]


def load_plugin(path: Path) -> ModuleType:
    """Import a module of the plugin folder; FoggyError that names its file if it cannot be imported."""
    if PLUGINS not in sys.modules:
        package = ModuleType(PLUGINS)
        package.__path__ = [str(folder) for folder in _plugins]
        sys.modules[PLUGINS] = package
    try:
        return importlib.import_module(f"{PLUGINS}.{path.stem}")
    except Exception as error:  # the user's own code may raise anything; the message names its file
        raise FoggyError(f"{path}: this plugin cannot be imported: {type(error).__name__}: {error}") from error
