"""Comparing what lies on disk with what run records and indexes say."""

from base64 import urlsafe_b64encode
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from foggy_synscapes.datasets.index import read_index
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.progress import progress
from foggy_synscapes.params import STAND_IN, Params
from foggy_synscapes.provenance.recorded import leaves, select, without_folders
from foggy_synscapes.provenance.runs import read_run, read_runs, record_of, state
from foggy_synscapes.results import INDEX, RESULTS, SCENES

SNAKEMAKE = Path(".snakemake")


def differences(path: Path) -> tuple[list[str], int]:
    """Compare the inputs and outputs of the records that have an output at or below `path`.

    Where an index of the stand-in is among them, the images that it lists are compared too.

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
        for word in ("missing", "changed"):
            if word in states:
                problems.append(f"{name}: {word} (recorded in {states[word]})")
    count = len(recorded)
    for index in map(Path, sorted(recorded)):
        if is_index(index) and index.is_file() and is_stand_in(index):
            listing = raw_state(index, Path(SCENES, dataset_of(index)))
            problems += [f"{file}: {word} (listed in {index})" for word, file in listing.problems()]
            count += listing.files
    return problems, count


def stale_results(params: Params) -> list[str]:
    """Results that Snakemake would take for up to date though their run records state other params than these.

    DVC or a person made them, so that Snakemake has no record of its own, or one that is older than the file. Records
    that cannot be read are left to those who need the files.
    """
    found, values = [], without_folders(params)
    for place in sorted(Path(RESULTS).rglob("*run.json")):
        try:
            record = read_run(place)
        except FoggyError:
            continue
        said = dict(leaves(record.get("params", {})))
        try:
            now = dict(leaves(select(values, *said)))
        except (KeyError, TypeError):
            now = {}  # a key that is gone
        if now != said:
            found += sorted(name for name in record["outputs"] if not _is_known_to_snakemake(Path(name)))
    return found


def _is_known_to_snakemake(path: Path) -> bool:
    """Whether Snakemake recorded a file after it was written, or that it was cut off while its job wrote it."""
    own = urlsafe_b64encode(path.as_posix().encode()).decode()  # how Snakemake names its records
    record = SNAKEMAKE / "metadata" / own
    if not path.exists() or (SNAKEMAKE / "incomplete" / own).exists():
        return True
    return record.is_file() and record.stat().st_mtime >= path.stat().st_mtime


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


@dataclass(frozen=True)
class RawState:
    """How the files that an index lists are on disk: their number, and those missing and changed."""

    files: int
    missing: list[str]
    changed: list[str]

    def problems(self) -> Iterable[tuple[str, str]]:
        """Pairs of what is wrong and the file."""
        yield from (("missing", name) for name in self.missing)
        yield from (("changed", name) for name in self.changed)


def raw_state(index: Path, root: Path) -> RawState:
    """Hash the files that an index lists, and compare."""
    listed = read_index(index)
    states = {
        str(root / path): state(root / path, digest)
        for path, digest in progress(listed.items(), f"verify {dataset_of(index)}", unit="file")
    }
    return RawState(
        len(states), *([name for name in states if states[name] == word] for word in ("missing", "changed"))
    )
