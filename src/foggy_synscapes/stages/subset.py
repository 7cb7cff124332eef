"""subset: the lists of (image, label) that a row trains on and is validated with. Copies no image."""

import argparse
from collections.abc import Iterator
from itertools import cycle, islice
from pathlib import Path

from foggy_synscapes.datasets import cityscapes, foggy_cityscapes, synscapes, uris
from foggy_synscapes.datasets.index import expect, index_path, read_index
from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.io.shards import read_manifest
from foggy_synscapes.io.tables import read_csv, write_csv
from foggy_synscapes.params import ClearList, FoggyList, MixedList, Params, load, root
from foggy_synscapes.provenance.recorded import recorded
from foggy_synscapes.provenance.runs import checked_inputs, write_run

HELP = "List the images and labels that a row of the tables trains on and is validated with."
FOLDER = Path("results/subset")
COLUMNS = ("image", "image_sha256", "label", "label_sha256")
KEPT = Path("results/filter/kept.csv")
REFINED = ("scenes.refined_list",)
# Params that each kind of list reads beside its own entry.
READ = {"clear": (), "partial": REFINED, "pure": ("scenes.shards",), "mixed": (*REFINED, "scenes.shards")}

Entry = tuple[str, str, str, str]


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this step."""
    parser.add_argument(
        "--row", required=True, help="row of the tables, e.g. FS-498: a key of the params section subset"
    )


def run(args: argparse.Namespace) -> None:
    """Run the step from the command line."""
    params = load(args.params)
    if args.row not in params.subset.rows():
        raise UsageError(
            f"--row {args.row}: not in the params section subset; it has {', '.join(params.subset.rows())}"
        )
    subset(params, args.row)


def subset(params: Params, row: str) -> None:
    """Write `train.csv` and `validation.csv` (image, its SHA-256, label map, its SHA-256) to results/subset/ROW.

    Raises
    ------
    FoggyError
        If a list asks for more frames than there are, or an image has no label map.
    """
    kind, entry = params.subset.kind(row), params.subset.rows()[row]
    inputs: dict[str, str] = {}
    lists = {"clear": _clear, "partial": _partial, "pure": _pure, "mixed": _mixed}[kind](params, entry, row, inputs)
    outputs = []
    for name, asked, entries in zip(("train", "validation"), _asked(kind, entry), lists, strict=True):
        if len(entries) != asked:
            raise FoggyError(f"subset.{kind}.{row}.{name}: {len(entries)} entries, expected {asked}")
        outputs.append(FOLDER / row / f"{name}.csv")
        write_csv(outputs[-1], COLUMNS, entries)
    write_run(
        FOLDER / row / "run.json",
        command=["foggy", "subset", "--row", row],
        params=recorded(params, f"subset.{kind}.{row}", *READ[kind]),
        inputs=inputs,
        outputs=outputs,
    )
    print(f"subset {row}: {len(lists[0])} training and {len(lists[1])} validation images")


def _asked(kind: str, entry: ClearList) -> tuple[int, int]:
    """Number of entries of the training and of the validation list."""
    if kind != "mixed":
        return entry.train, entry.validation
    purely, partly = entry.ratio
    return tuple(count + share(count, purely, partly) for count in (entry.train, entry.validation))


def share(count: int, purely: int, partly: int) -> int:
    """How many Foggy Cityscapes images go with `count` Foggy Synscapes images at a ratio of purely : partly.

    >>> share(498, 2, 1), share(5, 2, 1)
    (249, 3)
    """
    return -(-count * partly // purely)


def interleave(purely: list[Entry], partly: list[Entry], ratio: tuple[int, int]) -> list[Entry]:
    """Mix two lists group by group at a ratio; the second starts again from its first entry where it ends.

    >>> "".join(interleave(list("aaaa"), list("xyz"), (2, 1)))
    'aaxaay'
    """
    first, second = ratio
    again = cycle(partly)
    mixed: list[Entry] = []
    left = share(len(purely), first, second)
    for start in range(0, len(purely), first):
        mixed += purely[start : start + first]
        taken = min(second, left)
        mixed += islice(again, taken)
        left -= taken
    return mixed


def _take(available: list[str], count: int, what: str) -> list[str]:
    if count > len(available):
        raise FoggyError(f"{what}: asks for {count} frames, but there are {len(available)}. Ask for fewer.")
    return available[:count]


def _clear(params: Params, entry: ClearList, row: str, inputs: dict[str, str]) -> tuple[list[Entry], list[Entry]]:
    index = _read_indexes(["cityscapes/all"], inputs)

    def entries(split: str, count: int, name: str) -> list[Entry]:
        frames = _take(cityscapes.frames(index, split), count, f"subset.clear.{row}.{name}")
        return list(_pairs(index, index, [(cityscapes.image(frame), frame) for frame in frames], "cityscapes"))

    return entries("train", entry.train, "train"), entries("val", entry.validation, "validation")


def _partial(params: Params, entry: FoggyList, row: str, inputs: dict[str, str]) -> tuple[list[Entry], list[Entry]]:
    counts = entry.train, entry.validation
    return _foggy_cityscapes(params, entry.beta, counts, f"subset.partial.{row}", inputs)


def _foggy_cityscapes(
    params: Params, beta: str, counts: tuple[int | None, int | None], what: str, inputs: dict[str, str]
) -> tuple[list[Entry], list[Entry]]:
    """Refined images of both splits; a count of None takes all."""
    labels = _read_indexes(["cityscapes/all"], inputs)
    images = _read_indexes(["foggy_cityscapes/all"], inputs)
    folder, name = root(params, "foggy_cityscapes"), params.scenes.refined_list
    refined = foggy_cityscapes.read_refined(folder, name, images)
    result = []
    for split, count, part in zip(("train", "val"), counts, ("train", "validation"), strict=True):
        frames = refined[split] if count is None else _take(refined[split], count, f"{what}.{part}")
        if not frames:
            raise FoggyError(f"{folder / name}: names no frame of the {split} split")
        named = [(foggy_cityscapes.image(frame, beta), frame) for frame in frames]
        result.append(list(_pairs(images, labels, named, "foggy_cityscapes")))
    return result[0], result[1]


def _pairs(
    images: dict[str, str], labels: dict[str, str], named: list[tuple[str, str]], dataset: str
) -> Iterator[Entry]:
    """Entries of images whose label maps are those of Cityscapes."""
    expect(images, (image for image, _ in named), dataset)
    expect(labels, (cityscapes.labels(frame) for _, frame in named), "cityscapes")
    for image, frame in named:
        label = cityscapes.labels(frame)
        yield uris.of_dataset(dataset, image), images[image], uris.of_dataset("cityscapes", label), labels[label]


def _pure(params: Params, entry: FoggyList, row: str, inputs: dict[str, str]) -> tuple[list[Entry], list[Entry]]:
    """The first kept frames for training, the last for validation (paper, sections IV.A and IV.B)."""
    shards = params.scenes.shards
    index = _read_indexes([f"synscapes/{shard}" for shard in shards], inputs)
    manifests = [uris.FOG / f"beta_{entry.beta}" / f"{shard}.csv" for shard in shards]
    inputs.update(checked_inputs([*manifests, KEPT]))
    members = {
        member.name: (shard, member.sha256)
        for shard, path in zip(shards, manifests, strict=True)
        for member in read_manifest(path)
    }
    kept = [int(line["id"]) for line in read_csv(KEPT, ("id",))]
    asked = entry.train + entry.validation
    if asked > len(kept):
        raise FoggyError(
            f"subset.{params.subset.kind(row)}.{row}: asks for {entry.train} training and {entry.validation} "
            f"validation frames, but the filter kept {len(kept)}. Ask for fewer, loosen filter.rules, or add frames."
        )
    result = []
    for frames in (kept[: entry.train], kept[len(kept) - entry.validation :]):
        entries = []
        for frame in frames:
            name = synscapes.foggy_name(frame, entry.beta)
            name = name if name in members else uris.recipe(name)
            if name not in members:
                raise FoggyError(
                    f"{uris.FOG}/beta_{entry.beta}: no shard holds frame {frame}. Was it dropped for its blue "
                    "airlight? Then ask for fewer frames, or set fog.blue_airlight to keep or grey."
                )
            label = synscapes.class_(frame)
            expect(index, [label], "synscapes")
            shard, digest = members[name]
            entries.append(
                (uris.of_fog(entry.beta, shard, name), digest, uris.of_dataset("synscapes", label), index[label])
            )
        result.append(entries)
    return result[0], result[1]


def _mixed(params: Params, entry: MixedList, row: str, inputs: dict[str, str]) -> tuple[list[Entry], list[Entry]]:
    purely = _pure(params, entry, row, inputs)
    partly = _foggy_cityscapes(params, entry.beta_foggy_cityscapes, (None, None), f"subset.mixed.{row}", inputs)
    train, validation = (interleave(*lists, entry.ratio) for lists in zip(purely, partly, strict=True))
    return train, validation


def _read_indexes(names: list[str], inputs: dict[str, str]) -> dict[str, str]:
    inputs.update(checked_inputs(index_path(name) for name in names))
    return read_index(*names)
