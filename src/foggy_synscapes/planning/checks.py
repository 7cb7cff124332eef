"""What would end a run after hours, found in params and on disk before it begins; only what the jobs need counts."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from foggy_synscapes.jobs import Job
from foggy_synscapes.params import STAND_IN, Params
from foggy_synscapes.planning.plan import datasets
from foggy_synscapes.standin.layouts import STAND_INS

NO_WEIGHTS = "none"


def problems(params: Params, jobs: Sequence[Job]) -> list[str]:
    """A line for each thing that jobs need and that is not there or does not fit, naming the key of the params."""
    return [*_roots(params, jobs), *_lists(params, jobs), *_weights(params, jobs)]


def _roots(params: Params, jobs: Sequence[Job]) -> Iterator[str]:
    needed, roots = datasets(jobs), params.scenes.roots
    for name in needed:
        folder = roots[name]
        if folder != STAND_IN and not Path(folder).is_dir():
            state = "is no folder" if Path(folder).exists() else "does not exist"
            yield (
                f"scenes.roots.{name}: {folder} {state}; give the folder in which the dataset lies"
                f"{f', or {STAND_IN}' if name in STAND_INS else ''}"
            )
    for name in needed:
        for other in STAND_INS[name].others if name in STAND_INS else ():
            if other in roots and (roots[name] == STAND_IN) != (roots[other] == STAND_IN):
                real, drawn = (other, name) if roots[name] == STAND_IN else (name, other)
                yield (
                    f"scenes.roots: {real} is real ({roots[real]}), but {drawn} is the stand-in; their frames are the "
                    f"same ones, so name the folder of both, or draw both"
                )
    if any(job.step.name == "fog" for job in jobs) and roots["synscapes"] != STAND_IN:
        ends, held = params.fog.frames, len(params.scenes.shards) * params.scenes.shard_frames
        if ends.first + ends.last > held:
            yield f"scenes.shards: hold {held} frames, fewer than the {ends.first + ends.last} that fog.frames asks for"


def _lists(params: Params, jobs: Sequence[Job]) -> Iterator[str]:
    asked = {(job.values["network"], job.values["row"]) for job in jobs if job.step.word == "train"}
    for each in params.trainings():
        if (each.network, each.row) in asked and each.listed < each.policy.batch:
            yield (
                f"subset.{params.subset.kind(each.row)}.{each.row}: lists {each.listed} images, fewer than a batch of "
                f"{each.policy.batch} when {each.network} trains on it; list more, or lower its batch"
            )


def _weights(params: Params, jobs: Sequence[Job]) -> Iterator[str]:
    users: dict[str, list[str]] = {}
    for job in jobs:
        if job.step.name == "train_from_weights":
            network, row = job.values["network"], job.values["row"]
            users.setdefault(params.train.weights(network, row), []).append(f"{network} {row}")
    for path, names in users.items():
        if path != NO_WEIGHTS and not Path(path).is_file():
            rows = ", ".join(dict.fromkeys(names))
            yield f"train: {path}, which {rows} starts from, does not exist; make it by `foggy weights import`"


def unused(params: Params, jobs: Sequence[Job]) -> list[str]:
    """Keys of sections that no job reads: what stands there does not matter."""
    needed = set(datasets(jobs))
    found = [f"scenes.roots.{name}" for name in params.scenes.roots if name not in needed]
    read = set().union(*(job.keys() for job in jobs if job.step.word != "scenes"))
    sections = ["filter", "fog", *(f"subset.{kind}" for kind in params.subset.kinds())]
    for network in params.train.settings:
        own = f"train.{network}"
        parts = [f"{own}.baseline", f"{own}.fine_tuning"]
        sections += parts if _is_read(own, read) else [own]
    empty = {f"subset.{kind}" for kind, rows in params.subset.kinds().items() if not rows}
    empty |= {f"train.{name}.baseline" for name, each in params.train.settings.items() if each.baseline is None}
    return found + [section for section in sections if section not in empty and not _is_read(section, read)]


def _is_read(section: str, read: set[str]) -> bool:
    return any(f"{key}.".startswith(f"{section}.") or f"{section}.".startswith(f"{key}.") for key in read)
