"""The lineage of a result as a tree: file, the job that made it, the files that the job read, down to raw data."""

import json
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.provenance import source_digest
from foggy_synscapes.provenance.check import dataset_of, is_index, raw_state
from foggy_synscapes.provenance.runs import leaves, read_runs, state

UNCHANGED, MADE_AGAIN = "unchanged", "made again since it was read"
SHOWN = 3  # names of files that text repeats
WIDTH = 160  # characters of params that text shows


@dataclass
class Lineage:
    """All run records of a folder, and which of them made which file.

    roots : folder of each dataset, for raw data
    """

    roots: Mapping[str, Path]
    records: dict[Path, dict[str, Any]] = field(default_factory=read_runs)

    def __post_init__(self) -> None:
        self.makers = {name: place for place, record in self.records.items() for name in record["outputs"]}
        self._states: dict[tuple[str, str], str] = {}

    def maker(self, name: str) -> dict[str, Any]:
        """Record of the job that made a file; FoggyError if no record has the file among its outputs."""
        if name not in self.makers:
            raise FoggyError(
                f"{name}: no run record has it among its outputs. Was it made by this pipeline, from this folder?"
            )
        return self.records[self.makers[name]]

    def file(self, name: str, digest: str | None = None) -> dict[str, Any]:
        """Path, SHA-256 (as recorded by its maker, or as its reader saw it) and state of one file."""
        digest = digest or self.maker(name)["outputs"][name]
        if (name, digest) not in self._states:
            self._states[name, digest] = state(name, digest)
        node = {"path": name, "sha256": digest, "state": self._states[name, digest]}
        if name in self.makers and self.maker(name)["outputs"][name] != digest:
            # The reader had other bytes than the last maker wrote: something ran in between, or by hand.
            node["state"] = MADE_AGAIN
        return node

    def tree(self, name: str, depth: int | None = None) -> dict[str, Any]:
        """Lineage of a file, `depth` jobs deep (None: down to the raw data); a job that occurs again is not repeated.

        Raises FoggyError if no run record has the file among its outputs.
        """
        return self._node(name, self.maker(name)["outputs"][name], depth, set())

    def jobs(self, name: str) -> list[Path]:
        """Run records of all jobs behind a file, those that a job needs before it, each once.

        Raises FoggyError if no run record has the file among its outputs.
        """
        found: dict[Path, None] = {}
        self.maker(name)

        def visit(file: str) -> None:
            place = self.makers.get(file)
            if place is not None and place not in found:
                for each in self.records[place]["inputs"]:
                    visit(each)
                found[place] = None

        visit(name)
        return list(found)

    def _node(self, name: str, digest: str, depth: int | None, seen: set[Path]) -> dict[str, Any]:
        node = self.file(name, digest)
        if name not in self.makers:
            return node
        place = self.makers[name]
        record = self.records[place]
        node["command"], node["record"] = " ".join(record["command"]), place.as_posix()
        if place in seen:
            node["shown_above"] = True
        elif depth == 0:
            node["below"] = len(record["inputs"])
        else:
            seen.add(place)
            node |= about(record)
            deeper = None if depth is None else depth - 1
            node["inputs"] = [self._node(each, value, deeper, seen) for each, value in record["inputs"].items()]
        if is_index(Path(name)) and depth != 0 and Path(name) not in seen:
            seen.add(Path(name))
            root = self.roots[dataset_of(Path(name))]
            found = raw_state(Path(name), root) if Path(name).is_file() else {"files": 0, "missing": [], "changed": []}
            node["raw"] = {"folder": str(root), **found}
        return node


def about(record: dict[str, Any]) -> dict[str, Any]:
    """What a record says of its job beside files; sources that are not as they were then are named."""
    return {
        "params": record["params"],
        "code": record["code"],
        "code_changed": [name for name, digest in record["code"].items() if source_digest.now(name) != digest],
        "versions": record["versions"],
        "instructions": record.get("instructions", {}),
    }


def lines(node: dict[str, Any], depth: int = 0) -> Iterator[str]:
    """A tree in text: what does not match is marked by an arrow."""
    indent = "  " * depth
    yield indent + file_line(node)
    if "command" in node:
        yield f"{indent}  by: {node['command']}{'  (shown above)' if node.get('shown_above') else ''}"
    if "below" in node:
        yield f"{indent}  from {node['below']} files: a larger --depth shows them"
    if "params" in node:
        values = ", ".join(f"{key}={json.dumps(value, ensure_ascii=False)}" for key, value in leaves(node["params"]))
        yield f"{indent}  params: {values if len(values) <= WIDTH else values[:WIDTH] + ' ... (--json has all)'}"
        changed = arrow("changed since", node["code_changed"])
        yield f"{indent}  code: {len(node['code'])} modules  {source_digest.identity(node['code'])[:12]}{changed}"
    if "raw" in node:
        raw = node["raw"]
        wrong = "".join(arrow(kind, raw[kind]) for kind in ("missing", "changed"))
        yield f"{indent}  lists {raw['files']} files below {raw['folder']}{wrong}"
    for child in node.get("inputs", ()):
        yield from lines(child, depth + 1)


def file_line(node: dict[str, Any]) -> str:
    """Path, start of the SHA-256 and, where it does not match, what is wrong."""
    return f"{node['path']}  {node['sha256'][:12]}{'' if node['state'] == UNCHANGED else arrow(node['state'])}"


def arrow(what: str, names: Collection[str] | None = None) -> str:
    """An arrow to what is wrong, with the names that it is about; nothing where there are none.

    >>> arrow("missing", ["a", "b", "c", "d"]), arrow("missing", [])
    ('   <-- Missing: a, b, c and 1 more', '')
    """
    if names is None:
        return f"   <-- {what.capitalize()}"
    return f"   <-- {what.capitalize()}: {some(names)}" if names else ""


def some(names: Collection[str]) -> str:
    """The first of many names."""
    return ", ".join([*names][:SHOWN]) + (f" and {len(names) - SHOWN} more" if len(names) > SHOWN else "")
