"""From one printed cell of a table to its scores, model, start weights, lists and images."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.io.shards import Shard
from foggy_synscapes.io.tables import read_csv
from foggy_synscapes.labels import CLASSES
from foggy_synscapes.networks import NETWORKS, titles
from foggy_synscapes.provenance.lineage import SHOWN, UNCHANGED, Lineage, arrow, file_line, some
from foggy_synscapes.provenance.runs import state
from foggy_synscapes.results import FOG, METRICS, TABLE, run_file
from foggy_synscapes.scoring.metrics import read_scores
from foggy_synscapes.tables.ours import ANNOTATED, AS_PUBLISHED
from foggy_synscapes.tables.table import round_half_up

LISTS = ("train", "validation")


def trace_cell(lineage: Lineage, test_set: str, network: str, row: str, name: str) -> dict[str, Any]:
    """What one cell is made from.

    network : as printed or as in params, e.g. RefineNet, in any case; row : e.g. FS-498
    name : class as Cityscapes spells it, or "mean IoU annotated", "mean IoU as published"

    Raises UsageError if there is no such cell, FoggyError if the table was not made, or its runs were not.
    """
    keys = {text.lower(): key for key, printed in titles().items() for text in (key, printed)}
    names = {text.lower(): text for text in (*CLASSES, ANNOTATED, AS_PUBLISHED)}
    if network.lower() not in keys or name.lower() not in names:
        raise UsageError(
            f"--cell {network} {row} {name!r}: networks are {', '.join(titles().values())}; "
            f"scores are {', '.join(names.values())}"
        )
    network, name = keys[network.lower()], names[name.lower()]
    table = str(run_file(f"{TABLE}.csv", test_set))
    lines = [line for line in read_csv(table) if (line["network"], line["score"]) == (NETWORKS[network].title, name)]
    printed = {line["row"]: line for line in lines}
    if row not in printed:
        raise UsageError(f"--cell ... {row}: the table of {test_set} has the rows {', '.join(printed)}")
    cell = printed[row]
    value = _number(cell["ours"])
    seeds = [column.removeprefix("seed_") for column in cell if column.startswith("seed_")]
    made = [seed for seed in seeds if run_file(METRICS, test_set, network, row, seed).as_posix() in lineage.makers]
    if not made:
        raise FoggyError(f"{table}: row {row} of {NETWORKS[network].title} was not run; its cells are --")
    return {
        "test_set": test_set,
        "network": NETWORKS[network].title,
        "row": row,
        "score": name,
        "printed": "-" if value is None else str(round_half_up(value)),
        "value": value,
        "table": lineage.file(table),
        "runs": [_run(lineage, test_set, network, row, name, seed, cell[f"seed_{seed}"]) for seed in made],
    }


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _run(lineage: Lineage, test_set: str, network: str, row: str, name: str, seed: str, told: str) -> dict[str, Any]:
    path = run_file(METRICS, test_set, network, row, seed)
    scores = read_scores(path) or {"classes": [], "mean_iou": {}}
    counts: dict[str, Any] = next((entry for entry in scores["classes"] if entry["name"] == name), {})
    means = {ANNOTATED: "annotated", AS_PUBLISHED: "as_published"}
    value = scores["mean_iou"].get(means[name]) if name in means else counts.get("iou")
    record = lineage.maker(path.as_posix())
    model = next(file for file in record["inputs"] if file.endswith("model.safetensors"))
    index = next(file for file in record["inputs"] if file != model)
    predictions = path.with_name("predictions.tar")
    return {
        "seed": seed,
        "value": value,
        "table_agrees": _number(told) == value,
        "counts": {key: counts[key] for key in ("tp", "fp", "fn") if key in counts},
        "metrics": lineage.file(path.as_posix()),
        "predictions": {**lineage.file(predictions.as_posix()), "images": _members(predictions)},
        "test_index": lineage.file(index, record["inputs"][index]),
        "by": " ".join(record["command"]),
        "model": _model(lineage, model, record["inputs"][model]),
    }


def _members(shard: Path) -> list[str]:
    if not shard.is_file():
        return []
    with Shard(shard) as members:
        return members.names()


def _model(lineage: Lineage, name: str, digest: str) -> dict[str, Any]:
    """A model, the lists that it was trained on and what it started from."""
    record = lineage.maker(name)
    lists = [file for file in record["inputs"] if Path(file).stem in LISTS]
    starts = [file for file in record["inputs"] if file not in lists]
    node = {**lineage.file(name, digest), "by": " ".join(record["command"])}
    node["lists"] = [_list(lineage, file, record["inputs"][file]) for file in lists]
    for start in starts:
        seen = record["inputs"][start]
        node["start"] = _model(lineage, start, seen) if start in lineage.makers else lineage.file(start, seen)
    return node


def _list(lineage: Lineage, name: str, digest: str) -> dict[str, Any]:
    """A list, and its images by the shard or dataset that holds them."""
    node: dict[str, Any] = {**lineage.file(name, digest), "by": " ".join(lineage.maker(name)["command"])}
    sources: dict[str, list[dict[str, str]]] = {}
    for line in read_csv(name) if Path(name).is_file() else []:
        scheme, _, path = line["image"].partition(":")
        source, image = (
            (f"{FOG}/{path.partition('#')[0]}", path.partition("#")[2]) if scheme == "fog" else (scheme, path)
        )
        entry = {"image": image, "sha256": line["image_sha256"], "label": line["label"]}
        sources.setdefault(source, []).append({**entry, "label_sha256": line["label_sha256"]})
    node["count"] = sum(map(len, sources.values()))
    node["sources"] = [_source(lineage, source, images) for source, images in sources.items()]
    return node


def _source(lineage: Lineage, source: str, images: list[dict[str, str]]) -> dict[str, Any]:
    """Images of a list that lie in one shard, or in one dataset, of which those are named that are not as listed."""
    if source in lineage.makers:
        by = " ".join(lineage.maker(source)["command"])
        return {**lineage.file(source), "by": by, "changed": [], "images": images}
    folder = lineage.roots.get(source)
    changed = [
        entry["image"]
        for entry in images
        if folder is None or state(folder / entry["image"], entry["sha256"]) != UNCHANGED
    ]
    return {"path": source, "changed": changed, "images": images}


def cell_lines(cell: dict[str, Any]) -> Iterator[str]:
    """A cell and what it comes from, in text."""
    unrounded = "" if cell["value"] is None else f" ({cell['value']!r} percent)"
    yield f"{cell['test_set']}, {cell['network']}, {cell['row']}, {cell['score']}: {cell['printed']}{unrounded}"
    yield f"printed in {file_line(cell['table'])}"
    for run in cell["runs"]:
        counts = ", ".join(f"{key} {value}" for key, value in run["counts"].items())
        differs = "" if run["table_agrees"] else arrow("the table has another value: make it again")
        yield f"seed {run['seed']}: {run['value']!r}{f', pixels: {counts}' if counts else ''}{differs}"
        yield f"  scores       {file_line(run['metrics'])}"
        yield f"    by: {run['by']}"
        yield f"  predictions  {file_line(run['predictions'])}"
        yield f"    {_images(run['predictions']['images'])}"
        yield f"  test set     {file_line(run['test_index'])}"
        yield from _model_lines(run["model"], "  model        ", 1)


def _model_lines(model: dict[str, Any], title: str, depth: int) -> Iterator[str]:
    indent = "  " * depth
    yield f"{title}{file_line(model)}"
    if "by" in model:
        yield f"{indent}  by: {model['by']}"
    for entry in model.get("lists", ()):
        yield f"{indent}  list {file_line(entry)}: {entry['count']} images"
        yield f"{indent}    by: {entry['by']}"
        for source in entry["sources"]:
            name = file_line(source) if "sha256" in source else source["path"]
            yield f"{indent}    from {name}{arrow('changed', source['changed'])}"
            yield f"{indent}      {_images([image['image'] for image in source['images']])}"
    if "start" in model:
        yield from _model_lines(model["start"], f"{indent}  starts from ", depth + 1)


def _images(names: list[str]) -> str:
    return f"{len(names)} images: {some(names)}{' (--json has all)' if len(names) > SHOWN else ''}"
