"""The lineage of a result in lines of text."""

import json
from collections.abc import Iterator
from typing import Any

from foggy_synscapes.provenance import source_digest
from foggy_synscapes.provenance.recorded import leaves
from foggy_synscapes.provenance.tree import SHOWN, UNCHANGED

WIDTH = 160  # characters of params that are printed


def lines(node: dict[str, Any], depth: int = 0) -> Iterator[str]:
    """A tree in text: what does not match is marked by an arrow."""
    indent = "  " * depth
    yield indent + file_line(node)
    if "command" in node:
        yield f"{indent}  by: {node['command']}{'  (shown above)' if node.get('shown_above') else ''}"
    if "below" in node:
        yield f"{indent}  from {node['below']} files: a larger --depth shows them"
    if "params" in node:
        yield from (f"{indent}  {line}" for line in job_lines(node))
    if "raw" in node:
        yield f"{indent}  lists {raw_line(node['raw'])}"
    for child in node.get("inputs", ()):
        yield from lines(child, depth + 1)


def file_line(node: dict[str, Any]) -> str:
    """Path, start of the SHA-256 and, where it does not match, what is wrong."""
    return f"{node['path']}  {node['sha256'][:12]}{_arrow('' if node['state'] == UNCHANGED else node['state'])}"


def job_lines(node: dict[str, Any]) -> Iterator[str]:
    """Params and code of a job."""
    values = ", ".join(f"{key}={json.dumps(value, ensure_ascii=False)}" for key, value in leaves(node["params"]))
    yield f"params: {values if len(values) <= WIDTH else values[:WIDTH] + ' ... (--json has all)'}"
    changed = f"changed since: {_some(node['code_changed'])}" if node["code_changed"] else ""
    yield f"code: {len(node['code'])} modules  {source_digest.identity(node['code'])[:12]}{_arrow(changed)}"


def raw_line(raw: dict[str, Any]) -> str:
    """The raw files of an index, and those that are not as listed."""
    wrong = [f"{kind}: {_some(raw[kind])}" for kind in ("missing", "changed") if raw[kind]]
    return f"{raw['files']} files below {raw['folder']}{_arrow('; '.join(wrong))}"


def _some(names: list[str]) -> str:
    return ", ".join(names[:SHOWN]) + (f" and {len(names) - SHOWN} more" if len(names) > SHOWN else "")


def _arrow(text: str) -> str:
    return f"   <-- {text[:1].upper() + text[1:]}" if text else ""


def cell_lines(cell: dict[str, Any]) -> Iterator[str]:
    """A cell and what it comes from, in text."""
    unrounded = "" if cell["value"] is None else f" ({cell['value']!r} percent)"
    yield f"{cell['test_set']}, {cell['network']}, {cell['row']}, {cell['score']}: {cell['printed']}{unrounded}"
    yield f"printed in {file_line(cell['table'])}"
    for run in cell["runs"]:
        counts = ", ".join(f"{key} {value}" for key, value in run["counts"].items())
        differs = "" if run["table_agrees"] else "the table has another value: make it again"
        yield f"seed {run['seed']}: {run['value']!r}{f', pixels: {counts}' if counts else ''}{_arrow(differs)}"
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
            changed = _arrow(f"changed: {_some(source['changed'])}" if source["changed"] else "")
            yield f"{indent}    from {file_line(source) if 'sha256' in source else source['path']}{changed}"
            yield f"{indent}      {_images([image['image'] for image in source['images']])}"
    if "start" in model:
        yield from _model_lines(model["start"], f"{indent}  starts from ", depth + 1)


def _images(names: list[str]) -> str:
    return f"{len(names)} images: {_some(names)}{' (--json has all)' if len(names) > SHOWN else ''}"
