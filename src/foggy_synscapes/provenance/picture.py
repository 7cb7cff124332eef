"""The lineage of a result as a picture: its jobs, those of one word in one box where they stand side by side."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from foggy_synscapes.io.svg import Box, drawing
from foggy_synscapes.provenance.check import dataset_of, is_index, raw_state
from foggy_synscapes.provenance.lineage import UNCHANGED, Lineage

WIDTH = 34  # characters of a line
COMMANDS = 40  # that a pointer on a box shows
TARGET = "target"


def lineage_svg(lineage: Lineage, files: Sequence[str], title: str, lines: Sequence[str], wrong: bool = False) -> str:
    """What files were made from, down to the raw data, as SVG.

    files : results; title, lines : of the box that they lead to; wrong : whether it is not as it should be

    Raises FoggyError if no run record has a file among its outputs.
    """
    makers = {lineage.makers[name] for name in files if lineage.maker(name)}
    reads = _reads(lineage, files)
    level = _levels(reads, makers)
    groups: dict[str, list[Path]] = {}
    for place in sorted(reads):
        groups.setdefault(_group(lineage, place, level[place]), []).append(place)
    of_job = {place: key for key, found in groups.items() for place in found}
    boxes = {key: _box(lineage, found) for key, found in groups.items()}
    arrows = {(of_job[one], of_job[place]) for place, found in reads.items() for one in found}
    for place in reads:
        for name in _from_outside(lineage, place):
            node = lineage.file(name, lineage.records[place]["inputs"][name])
            boxes[name] = Box(_clipped(Path(name).name), [_clipped(f"sha256 {node['sha256'][:12]}")], name)
            arrows.add((name, of_job[place]))
    boxes[TARGET] = Box(title, lines, "\n".join(files), wrong)
    arrows |= {(of_job[place], TARGET) for place in makers}
    return drawing(boxes, arrows, f"What leads to {title}")


def file_svg(lineage: Lineage, name: str) -> str:
    """What a file was made from, as SVG; FoggyError if no run record has it among its outputs."""
    node = lineage.file(name)
    lines = [str(Path(name).parent), f"sha256 {node['sha256'][:12]}"]
    wrong = node["state"] != UNCHANGED
    return lineage_svg(lineage, [name], Path(name).name, [*lines, node["state"]] if wrong else lines, wrong)


def cell_svg(lineage: Lineage, cell: dict[str, Any]) -> str:
    """What a cell, as `cell.trace_cell` gives it, was made from, as SVG."""
    title = f"{cell['network']} {cell['row']}, {cell['score']}: {cell['printed']}"
    seeds = ", ".join(run["seed"] for run in cell["runs"])
    lines = [f"on {cell['test_set']}, seed {seeds}", f"in {cell['table']['path']}"]
    wrong = cell["table"]["state"] != UNCHANGED or not all(run["table_agrees"] for run in cell["runs"])
    return lineage_svg(
        lineage,
        [run["metrics"]["path"] for run in cell["runs"]],
        title,
        [*lines, "not as it was made"] if wrong else lines,
        wrong,
    )


def _reads(lineage: Lineage, files: Iterable[str]) -> dict[Path, set[Path]]:
    """Jobs behind files, by their records, and those that each reads from."""
    found: dict[Path, set[Path]] = {}
    waiting = [lineage.makers[name] for name in files]
    while waiting:
        place = waiting.pop()
        if place not in found:
            inputs = lineage.records[place]["inputs"]
            found[place] = {lineage.makers[name] for name in inputs if name in lineage.makers} - {place}
            waiting += found[place]
    return found


def _levels(reads: dict[Path, set[Path]], ends: Iterable[Path]) -> dict[Path, int]:
    """Of each job, the jobs on the longest way from it to the end."""
    level = dict.fromkeys(ends, 0)
    waiting = list(level)
    while waiting:
        place = waiting.pop()
        for one in reads[place]:
            if level.get(one, -1) < level[place] + 1:
                level[one] = level[place] + 1
                waiting.append(one)
    return level


def _group(lineage: Lineage, place: Path, level: int) -> str:
    return f"{level:04} {_word(lineage.records[place])}"


def _word(record: dict[str, Any]) -> str:
    return " ".join(record["command"][1:2]) or record["command"][0]


def _from_outside(lineage: Lineage, place: Path) -> list[str]:
    """Inputs of a job that no job made, such as weights."""
    return [name for name in lineage.records[place]["inputs"] if name not in lineage.makers]


def _box(lineage: Lineage, places: list[Path]) -> Box:
    """Jobs of one word, with what their commands differ in, and what is no longer as it was."""
    records = [lineage.records[place] for place in places]
    word, many = _word(records[0]), len(places)
    options: dict[str, dict[str, None]] = {}
    for record in records:
        words = record["command"]
        for name, value in zip(words, [*words[1:], "--"], strict=True):
            if name.startswith("--"):
                options.setdefault(name[2:], {}).update({} if value.startswith("--") else {value: None})
    lines = [_option(name, [*values]) for name, values in options.items()]
    written = [name for record in records for name in record["outputs"]]
    changed = [name for name in written if lineage.file(name)["state"] != UNCHANGED]
    for name in written:
        if is_index(Path(name)) and Path(name).is_file():
            found = raw_state(Path(name), lineage.roots[dataset_of(Path(name))])
            changed += [*found["missing"], *found["changed"]]
            lines.append(f"{dataset_of(Path(name))}: {found['files']:,} files")
    if changed:
        lines.append(f"{len(changed)} files missing or changed")
    commands = [" ".join(record["command"]) for record in records]
    more = [f"and {many - COMMANDS} more"] if many > COMMANDS else []
    hint = "\n".join([*commands[:COMMANDS], *more, *changed[:COMMANDS]])
    return Box(f"{word} × {many}" if many > 1 else word, [*dict.fromkeys(lines)], hint, bool(changed))


def _option(name: str, values: list[str]) -> str:
    """An option with as many of its values as a line holds, and how many they are."""
    whole = f"{name}: {', '.join(values)}" if values else name
    if len(values) < 2 or len(whole) <= WIDTH:
        return _clipped(whole)
    tail, some = f" ... ({len(values)})", values[:]
    while len(some) > 1 and len(f"{name}: {', '.join(some)}{tail}") > WIDTH:
        some.pop()
    return f"{name}: {', '.join(some)}{tail}"


def _clipped(text: str) -> str:
    return text if len(text) <= WIDTH else f"{text[: WIDTH - 3]}..."
