"""The jobs that make a target, by the table of steps: what both engines would run where nothing is made yet."""

from collections.abc import Iterable

from foggy_synscapes.errors import UsageError
from foggy_synscapes.jobs import Job
from foggy_synscapes.params import Params
from foggy_synscapes.steps import steps

TARGETS = {
    "all": ("tables", "figures", "stability"),
    "paper": ("tables_paper",),
}
"""Words and steps whose outputs a target of Snakemake asks for; each word and step is a target too."""


def outputs(params: Params, target: str) -> list[str]:
    """Files that a target of TARGETS asks for."""
    return [str(path) for job in _named(params, target) for path in job.outputs()]


def jobs(params: Params, targets: Iterable[str] = ("all",)) -> list[Job]:
    """The jobs that make these targets, and all jobs that those wait for, in the order of the table.

    targets : of TARGETS, words, names of steps, or paths of results

    Raises UsageError where a target is none of these.
    """
    every = [Job(step, params, values) for step in steps() for values in step.all_values(params)]
    written = [[*map(str, job.outputs()), *map(str, job.outputs("record"))] for job in every]
    maker = {path: number for number, paths in enumerate(written) for path in paths}
    waiting: list[int] = []
    for target in targets:
        named = {path for job in _named(params, target) for path in map(str, job.outputs())} or {target}
        found = {maker[path] for path in named if path in maker}
        if not found:
            known = dict.fromkeys([*TARGETS, *(job.step.word for job in every), *(job.step.name for job in every)])
            raise UsageError(f"{target}: no target, and no result of these params. There are {', '.join(known)}")
        waiting += sorted(found)
    needed: set[int] = set()
    while waiting:
        number = waiting.pop()
        if number not in needed:
            needed.add(number)
            waiting += [maker[path] for path in map(str, every[number].awaited()) if path in maker]
    return [every[number] for number in sorted(needed)]


def _named(params: Params, target: str) -> list[Job]:
    """Jobs that a name asks for by itself; none where it is no name."""
    names = TARGETS.get(target, (target,))
    # A word stands for what belongs to the whole experiment; what does not is asked for by its own name or word alone.
    chosen = [step for step in steps() if step.name in names or (step.word in names and step.default)]
    chosen = chosen or [step for step in steps() if step.word in names]
    return [Job(step, params, values) for step in chosen for values in step.all_values(params)]
