"""Which results are not those of a clean run: judged by content, for every job, whoever ran it.

A job is out of date where its run record states other code, libraries, params, command or inputs than today's, or there
is none; and so is what follows it. Times say nothing, and neither does what an engine remembers. A job whose outputs
alone are not as recorded is done again, but nothing that follows it: it comes out as it was recorded. So is a job whose
outputs are missing.
"""

import json
from collections import defaultdict
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from foggy_synscapes.datasets.index import changed_since_listed, index_digest
from foggy_synscapes.datasets.roots import files_of
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.stamps import Stamps
from foggy_synscapes.jobs import Each, Job
from foggy_synscapes.params import STAND_IN, Params
from foggy_synscapes.provenance.runs import code_of, read_run, remembered, select, stamps_of, without_folders
from foggy_synscapes.results import RESULTS, root
from foggy_synscapes.steps import all_jobs

OWN = ("python", "foggy-synscapes")
"""Versions that records state and that make nothing run again."""


@dataclass(frozen=True)
class Node:
    """A job beside the others.

    record : where it can be read; read, added, written : files that it reads, those of them that may be missing, and
        those that it writes; stamps : what is known of the content of its files
    """

    job: Job
    record: dict[str, Any] | None
    read: tuple[str, ...]
    added: tuple[str, ...]
    written: tuple[str, ...]
    stamps: Stamps

    @property
    def name(self) -> str:
        return " ".join(self.job.command)

    @property
    def awaited(self) -> tuple[str, ...]:
        """Files that have to be there before it runs."""
        return _texts(self.job.awaited())

    @property
    def is_there(self) -> bool:
        """Whether any of its outputs is."""
        return any(Path(path).exists() for path in self.written)


class Current:
    """All jobs of the params, and which of them have to run."""

    def __init__(self, params: Params) -> None:
        self.values = without_folders(params)
        self.nodes = {node.name: node for node in map(_node, all_jobs(params))}
        self.makers = {path: node.name for node in self.nodes.values() for path in node.written}
        self._code: dict[tuple[str, ...], tuple[dict[str, str], dict[str, str]]] = {}

    @cached_property
    def reasons(self) -> dict[str, str]:
        """Why jobs are out of date by themselves, by their command."""
        found = {name: self._reason(node) for name, node in self.nodes.items()}
        return {name: why for name, why in found.items() if why}

    @cached_property
    def altered(self) -> dict[str, str]:
        """Jobs that are up to date but for an output that somebody changed, with that output."""
        found: dict[str, str] = {}
        for name, node in self.nodes.items():
            if name not in self.reasons and node.record is not None:
                outputs = node.record["outputs"].items()
                wrong = [path for path, digest in outputs if node.stamps.state(path, digest) == "changed"]
                found |= {name: wrong[0]} if wrong else {}
        return found

    def planned(self, forced: Collection[str] = ()) -> dict[str, str]:
        """The jobs that are out of date, each with the reason, and what follows them.

        forced : names of steps, or files, that are made whatever is known of them
        """
        chosen = {
            name
            for name, node in self.nodes.items()
            if node.job.step.name in forced or not {*node.written}.isdisjoint(forced)
        }
        found = dict.fromkeys(chosen, "asked for") | self.reasons
        waiting, readers = [*found], self._readers
        while waiting:
            for path in self.nodes[waiting.pop()].written:
                for reader in readers[path]:
                    if reader not in found:
                        found[reader] = f"{path} is made again"
                        waiting.append(reader)
        return found

    def missing(self, asked: Iterable[str], running: Iterable[str]) -> set[str]:
        """Jobs of which a file is missing that is asked for, or that a job reads which runs or is itself among them.

        asked : paths of results; running : commands of jobs
        """
        found, waiting = set(running), [*asked]
        for name in running:
            waiting += self.nodes[name].awaited
        while waiting:
            path = waiting.pop()
            if path in self.makers and self.makers[path] not in found and not Path(path).exists():
                found.add(self.makers[path])
                waiting += self.nodes[self.makers[path]].awaited
        return found.difference(running)

    @cached_property
    def _readers(self) -> dict[str, list[str]]:
        found: dict[str, list[str]] = defaultdict(list)
        for name, node in self.nodes.items():
            for path in node.read:
                found[path].append(name)
        return found

    def _reason(self, node: Node) -> str:
        """Why a job is out of date by itself; empty where it is not."""
        record, job = node.record, node.job
        if record is None:
            return "it has no run record" if node.is_there else "it was not made yet"
        code, libraries = self._code_of(job)
        versions = {name: value for name, value in record.get("versions", {}).items() if name not in OWN}
        params = select(self.values, *job.keys())
        changes: list[tuple[str, Any, Any]] = [
            ("its code", record.get("code"), code),
            ("a library", versions, libraries),
            ("its params", record.get("params"), json.loads(json.dumps(params))),
            ("its command", record["command"], job.command),
            ("the list of its outputs", sorted(record["outputs"]), sorted({*node.written} - {_record_of(job)})),
        ]
        for what, before, now in changes:
            if before != now:
                return f"{what} changed{_difference(before, now)}"
        return self._changed_input(node, record["inputs"]) or _changed_listing(node)

    def _changed_input(self, node: Node, recorded: dict[str, str]) -> str:
        for path, digest in recorded.items():
            if path not in node.read:
                return f"it read {path}, which is none of its inputs now"
            if self._today(node, path) != digest:
                return f"{path} is not what it read"
        # Of files that may be missing, such as scores of runs that were not made, another may have come.
        added = [path for path in node.added if path not in recorded and self._today(node, path)]
        return f"{added[0]} is new" if added else ""

    def _today(self, node: Node, path: str) -> str | None:
        """What a file holds, or comes to hold where it is made again as recorded; None where nothing is known of it."""
        maker = self.nodes[self.makers[path]].record if path in self.makers else None
        if maker is not None:
            return maker["outputs"].get(path)
        return node.stamps.sha256(path) if Path(path).is_file() and not path.startswith(f"{RESULTS}/") else None

    def _code_of(self, job: Job) -> tuple[dict[str, str], dict[str, str]]:
        key = (job.step.word, *job.code())
        if key not in self._code:
            self._code[key] = code_of(job)
        return self._code[key]


class Again(NamedTuple):
    """A job that has to run again, and why; `alone` where it comes out as recorded, so that nothing follows it."""

    node: Node
    why: str
    alone: bool


def out_of_date(params: Params, forced: Collection[str] = (), asked: Collection[str] = ()) -> list[Again]:
    """Jobs that have to run, by `Current.planned` and `Current.altered`; what is hashed is known the next time.

    asked : paths of results whose missing files count too, where an altered one may be read for them
    """
    current = Current(params)
    planned, altered = current.planned(forced), current.altered
    found = [Again(current.nodes[name], why, False) for name, why in planned.items()]
    found += [Again(current.nodes[name], f"{altered[name]} was altered", True) for name in altered.keys() - planned]
    # An engine finds what is missing itself, but not that it has to wait for an output which is made again as it was.
    missing = current.missing(asked, [each.node.name for each in found]) if altered else ()
    found += [Again(current.nodes[name], "a file that it wrote is missing", True) for name in sorted(missing)]
    for node in current.nodes.values():
        node.stamps.save()
    return found


def changed_raw_data(job: Job) -> list[Path]:
    """Files of a dataset that are not as the job which lists them found them."""
    folder = root(job.params, job.command[-1])
    return [folder / path for index in job.outputs("index") for path in changed_since_listed(index, folder)]


def _changed_listing(node: Node) -> str:
    """Why the job that lists a real dataset would list something else, where its index cannot tell; else empty.

    No record states raw files, so only the index as it was listed says what they were: where it is missing or altered,
    they are listed again to see.
    """
    job = node.job
    if job.step.word != "scenes" or job.params.scenes.roots[job.command[-1]] == STAND_IN:
        return ""
    recorded, folder = node.record["outputs"] if node.record else {}, root(job.params, job.command[-1])
    for index in job.outputs("index"):
        digest = recorded.get(index.as_posix(), "")
        try:
            if node.stamps.state(index, digest) != "unchanged":
                paths = files_of(job.command[-1], folder, job.params.scenes, index.stem)
                if index_digest(index, folder, paths) != digest:
                    return "its raw files changed"
        except FoggyError as error:
            return str(error)
    return ""


def raw_data_in_words(job: Job, changed: Sequence[Path], option: str = "") -> str:
    """Why nothing can be planned while files of a dataset are not as they were listed, and what to do.

    job : the one that lists them; option : by which its command is told of the params file
    """
    name = job.command[-1]
    folder = root(job.params, name)
    if job.params.scenes.roots[name] != STAND_IN and not folder.is_dir():
        state = "is no folder" if folder.exists() else "does not exist"
        return (
            f"scenes.roots.{name}: {folder} {state}, though its files were listed before. Give the dataset's "
            "folder, e.g. mount it; `foggy params --check` names all that a run lacks."
        )
    return (
        f"{len(changed)} files are not as they were listed, first {changed[0]}. Run `{' '.join(job.command)}{option}`, "
        "then this again: only what the change reaches is made anew."
    )


def _node(job: Job) -> Node:
    written = (*_texts(job.outputs()), _record_of(job))
    # Where nothing is left of what a job made, such as shards that take up space, what is remembered of it stands.
    gone = not any(Path(path).exists() for path in written)
    try:
        record = read_run(remembered(job) if gone else job.output("record"))
    except FoggyError:
        record = None
    step, values = job.step, (job.params, job.values)
    gathered = [path for each in step.inputs.values() if isinstance(each, Each) for path in step.files(each, *values)]
    return Node(
        job,
        record,
        read=_texts(job.read()),
        added=_texts([*gathered, *(step.optional(*values) if step.optional else ())]),
        written=written,
        stamps=stamps_of(job),
    )


def _record_of(job: Job) -> str:
    return job.output("record").as_posix()


def _texts(paths: Iterable[str | Path]) -> tuple[str, ...]:
    return tuple(Path(path).as_posix() for path in paths)


def _difference(before: Any, now: Any) -> str:
    """The first key by which two mappings differ."""
    if not isinstance(before, dict) or not isinstance(now, dict):
        return ""
    names = [name for name in sorted({*before, *now}) if before.get(name) != now.get(name)]
    return f" ({names[0]}{f' and {len(names) - 1} more' if len(names) > 1 else ''})"
