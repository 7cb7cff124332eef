"""Comparing what lies on disk with what run records and indexes say."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from foggy_synscapes.datasets.index import read_index
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.progress import progress
from foggy_synscapes.params import STAND_IN
from foggy_synscapes.provenance.runs import read_run, read_runs, record_of, state
from foggy_synscapes.results import INDEX, SCENES

WRONG = ("missing", "changed")


def differences(path: Path, roots: Mapping[str, Path]) -> tuple[list[str], int]:
    """Compare the inputs and outputs of the records that have an output at or below `path`.

    Where an index of the stand-in, or of a dataset in `roots`, is among them, what it lists is compared too.

    Returns
    -------
    A line for each file that is missing, changed, or recorded with two contents; and the number of files compared.

    Raises
    ------
    FoggyError
        If no record speaks of `path`.
    """
    recorded: dict[str, dict[str, str]] = {}
    for place, record in read_runs().items():
        if any(Path(name).is_relative_to(path) for name in record["outputs"]):
            for name, digest in record["inputs"].items():
                recorded.setdefault(name, {}).setdefault(digest, str(place))
            for name, digest in record["outputs"].items():  # where both know a file, its maker's record is named
                recorded.setdefault(name, {})[digest] = str(place)
    if not recorded:
        raise FoggyError(f"{path}: no run record speaks of it. Paths are relative to the project's folder: results/...")
    problems = []
    for name, digests in progress(sorted(recorded.items()), "verify", unit="file"):
        states = {state(name, digest): place for digest, place in digests.items()}
        for word in WRONG:
            if word in states:
                problems.append(f"{name}: {word} (recorded in {states[word]})")
    count = len(recorded)
    for index in filter(is_index, map(Path, sorted(recorded))):
        dataset = dataset_of(index)
        if index.is_file() and (dataset in roots or is_stand_in(index)):
            listing = raw_state(index, roots.get(dataset, Path(SCENES, dataset)))
            problems += [f"{file}: {word} (listed in {index})" for word in WRONG for file in listing[word]]
            count += listing["files"]
    return problems, count


def verify(path: Path, roots: Mapping[str, Path] | None = None) -> int:
    """Number of files at or below `path` that are as recorded; FoggyError naming those that are not.

    roots : folder of each dataset, to compare all raw data that indexes list and not only the stand-in
    """
    problems, count = differences(path, roots or {})
    if problems:
        told = [f"{len(problems)} of {count} files are not what their run records say:", *problems]
        raise FoggyError("\n".join([*told, "Run the engine: what is not as recorded, it makes again."]))
    return count


def is_index(path: Path) -> bool:
    """Whether a result is the index of a dataset, or of a shard of one: where lineage meets raw data."""
    return path.is_relative_to(INDEX) and path.suffix == ".csv"


def dataset_of(index: Path) -> str:
    """The dataset that an index lists.

    >>> dataset_of(Path(INDEX, "cityscapes/all.csv"))
    'cityscapes'
    """
    return index.relative_to(INDEX).parts[0]


def is_stand_in(index: Path) -> bool:
    """Whether the record of an index says that its dataset was drawn."""
    place = record_of(index)
    roots = read_run(place).get("params", {}).get("scenes", {}).get("roots", {}) if place.is_file() else {}
    return roots.get(dataset_of(index)) == STAND_IN


def raw_state(index: Path, root: Path) -> dict[str, Any]:
    """Hash the files that an index lists: how many there are, and which are missing and which changed."""
    listed = progress(read_index(index).items(), f"verify {dataset_of(index)}", unit="file")
    states = {str(root / path): state(root / path, digest) for path, digest in listed}
    wrong = {word: [name for name, found in states.items() if found == word] for word in WRONG}
    return {"files": len(states), **wrong}
