"""The lineage of a result as a tree: file, the job that made it, the files that the job read, down to raw data."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.provenance import source_digest
from foggy_synscapes.provenance.check import RawState, dataset_of, is_index, raw_state
from foggy_synscapes.provenance.runs import read_runs, state

UNCHANGED, MADE_AGAIN = "unchanged", "made again since it was read"
SHOWN = 3  # names of files that text repeats


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
        """Record of the job that made a file.

        Raises
        ------
        FoggyError
            If no record has the file among its outputs.
        """
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
            node["raw"] = self._raw(Path(name))
        return node

    def _raw(self, index: Path) -> dict[str, Any]:
        root = self.roots[dataset_of(index)]
        found = raw_state(index, root) if index.is_file() else RawState(0, [], [])
        return {"folder": str(root), **asdict(found)}


def about(record: dict[str, Any]) -> dict[str, Any]:
    """What a record says of its job beside files; sources that are not as they were then are named."""
    return {
        "params": record["params"],
        "code": record["code"],
        "code_changed": [name for name, digest in record["code"].items() if source_digest.now(name) != digest],
        "versions": record["versions"],
        "instructions": record.get("instructions", {}),
    }
