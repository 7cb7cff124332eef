"""Kinds of jobs and single jobs: templates of paths, filled from params and the values of wildcards."""

import re
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import Any

from foggy_synscapes.params import Params

PLACEHOLDER = re.compile(r"\{(\w+)(?:\.(\w+))?\}")

EVERY = ".*"
"""At the end of a params key: each entry of the section that is not empty, so that a new kind of entry, of which there
is none yet, changes nothing."""

Values = Mapping[str, str]


@dataclass(frozen=True)
class Each:
    """One file of a folder for each value of further wildcards; DVC, which lists no files by pattern, takes the folder.

    folder, files : templates; of : by further wildcard, the params keys that list its values
    """

    folder: str
    files: str
    of: Mapping[str, tuple[str, ...]]


Template = str | Each
Found = Callable[[Params, Values], Iterable[str]]


@dataclass(frozen=True)
class Step:
    """One kind of job.

    name : of the rule and of the stage; word : the command, with which it begins
    wildcards : by name, the params key that lists its values: names, or a mapping with an entry for each
    inputs, outputs : by the name under which the command knows them, templates below the project's folder; the output
        `record` is the run record
    params : keys that it reads; subset.* are the entries of `subset` that are not empty
    asked : a params key without which there is no such job
    code : registered entries whose modules it runs beside those of its word, such as networks.{network}; those that a
        params key lists are networks.*train.networks
    waits : files that have to be there, but whose content another input vouches for
    optional : files that count where they are there
    folders : what DVC takes for outputs instead
    metrics, plots : outputs that DVC shows, with what is plotted of them
    megabytes, minutes, gpu, threads (a params key) : what it asks of a cluster
    priority : before others where both could run
    default : part of the whole experiment
    only : params -> by wildcard, also by a further one of an `Each`, the values that count among those that are listed
    """

    name: str
    word: str
    text: str
    command: str
    outputs: Mapping[str, Template]
    inputs: Mapping[str, Template] = field(default_factory=dict)
    wildcards: Mapping[str, str] = field(default_factory=dict)
    params: tuple[str, ...] = ()
    asked: str = ""
    code: tuple[str, ...] = ()
    waits: Found | None = None
    optional: Found | None = None
    folders: tuple[str, ...] = ()
    metrics: tuple[str, ...] = ()
    plots: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    threads: str = ""
    megabytes: int = 1_000
    minutes: int = 60
    gpu: bool = False
    priority: int = 0
    default: bool = True
    only: Callable[[Params], Mapping[str, Collection[str]]] | None = None

    @property
    def rule(self) -> str:
        """Snakemake's name of it: a word is the target of all its jobs, so a rule with wildcards is `fog_each`."""
        return f"{self.name}_each" if self.name == self.word and self.wildcards else self.name

    def fill(self, template: str, params: Params, values: Values) -> str:
        """A template with its wildcards' values; `{row.beta}` is a value of the wildcard's entry in the params."""

        def value(match: re.Match) -> str:
            name, attribute = match.groups()
            if attribute is None:
                return values[name]
            return str(getattr(at(params, f"{self.wildcards[name]}.{values[name]}"), attribute))

        return PLACEHOLDER.sub(value, template)

    def files(self, template: Template, params: Params, values: Values) -> list[str]:
        """The files that a template stands for."""
        if isinstance(template, str):
            return [self.fill(template, params, values)]
        lists, whole = self._lists(template.of, params), f"{template.folder}/{template.files}"
        chosen = (dict(zip(template.of, found, strict=True)) for found in product(*lists))
        return [self.fill(whole, params, {**values, **more}) for more in chosen]

    def templates(self, template: Template, params: Params) -> list[str]:
        """Templates of single files, in which the wildcards of this step stay."""
        return self.files(template, params, {name: f"{{{name}}}" for name in self.wildcards})

    def all_inputs(self, params: Params, values: Values) -> list[str]:
        """Every file that a job reads and that an engine knows before it runs."""
        found = [path for template in self.inputs.values() for path in self.files(template, params, values)]
        return found + (list(self.optional(params, values)) if self.optional else [])

    def all_values(self, params: Params) -> list[dict[str, str]]:
        """Values of the wildcards of every job of this kind."""
        if self.asked and not has(params, self.asked):
            return []
        lists = self._lists({name: (key,) for name, key in self.wildcards.items()}, params)
        return [dict(zip(self.wildcards, found, strict=True)) for found in product(*lists)]

    def _lists(self, keys: Mapping[str, tuple[str, ...]], params: Params) -> list[list[str]]:
        """The values of each wildcard, by the params keys that list them."""
        only = self.only(params) if self.only else {}
        return [
            [value for value in listed(params, *each) if name not in only or value in only[name]]
            for name, each in keys.items()
        ]

    def keys(self, params: Params) -> list[str]:
        """Params keys that jobs of this kind read, with the wildcards of this step."""
        found: list[str] = []
        for key in self.params:
            section, every, _ = key.partition(EVERY)
            entries = [name for name, value in at(params, section) if value] if every else []
            found += [f"{section}.{name}" for name in entries] if every else [key]
        return found

    def code_wildcards(self) -> list[str]:
        """Wildcards by which the code of jobs of this kind differs."""
        return [name for name in self.wildcards if any(f"{{{name}}}" in entry for entry in self.code)]


@dataclass(frozen=True)
class Job:
    """One job: a step and the values of its wildcards."""

    step: Step
    params: Params
    values: Values

    @property
    def command(self) -> list[str]:
        """The command that runs it, without the option that names the params file."""
        return ["foggy", *(self.step.fill(word, self.params, self.values) for word in self.step.command.split())]

    def inputs(self, name: str) -> list[Path]:
        """Files that it reads under a name."""
        return [Path(path) for path in self.step.files(self.step.inputs[name], self.params, self.values)]

    def input(self, name: str) -> Path:
        """The one file that it reads under a name."""
        (path,) = self.inputs(name)
        return path

    def one(self, name: str, **values: str) -> Path:
        """The file among those of an `Each` that it reads for these values of its further wildcards."""
        template = self.step.inputs[name]
        if isinstance(template, str):
            raise ValueError(f"{name}: a single file; ask by `input`")
        return Path(self.step.fill(f"{template.folder}/{template.files}", self.params, {**self.values, **values}))

    def read(self) -> list[Path]:
        """All files that it reads, each once."""
        return [Path(path) for path in dict.fromkeys(self.step.all_inputs(self.params, self.values))]

    def awaited(self) -> list[Path]:
        """All files that have to be there before it runs: those that it reads, and those that it only waits for."""
        waits = self.step.waits(self.params, self.values) if self.step.waits else []
        return [*self.read(), *map(Path, waits)]

    def outputs(self, *names: str) -> list[Path]:
        """Files that it writes under these names, or all of them but its record."""
        chosen = names or [name for name in self.step.outputs if name != "record"]
        files = self.step.files
        return [Path(path) for name in chosen for path in files(self.step.outputs[name], self.params, self.values)]

    def output(self, name: str) -> Path:
        """The one file that it writes under a name."""
        (path,) = self.outputs(name)
        return path

    def keys(self) -> list[str]:
        """Params keys that it reads."""
        return [self.step.fill(key, self.params, self.values) for key in self.step.keys(self.params)]

    def code(self) -> list[str]:
        """Registered entries whose code it runs, as REGISTRY.NAME."""
        found: list[str] = []
        for template in self.step.code:
            registry, _, name = template.partition(".")
            names = listed(self.params, name[1:]) if name.startswith("*") else [name]
            found += [self.step.fill(f"{registry}.{each}", self.params, self.values) for each in names]
        return found


def at(params: Params, key: str) -> Any:
    """What a dotted key of params names; numbers count the entries of lists."""
    found: Any = params
    for part in key.split("."):
        if isinstance(found, Mapping):
            found = found[part]
        else:
            found = found[int(part)] if isinstance(found, list | tuple) else getattr(found, part)
    return found


def has(params: Params, key: str) -> bool:
    """Whether there is anything at a dotted key of params."""
    try:
        return at(params, key) is not None
    except (KeyError, IndexError, AttributeError):
        return False


def listed(params: Params, *keys: str) -> list[str]:
    """The names that params keys list: entries of lists, keys of mappings, or one name."""
    found: list[str] = []
    for key in keys:
        value = at(params, key)
        found += [value] if isinstance(value, str) else [*value]
    return found
