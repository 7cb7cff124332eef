"""The JSON Schema of params files and the table of all keys, both from the sections' fields."""

import json
from collections.abc import Iterator
from typing import Any, NamedTuple, get_args, get_origin

from pydantic.fields import FieldInfo

from foggy_synscapes.params.experiment import model
from foggy_synscapes.params.resolved import facts, flow, unit
from foggy_synscapes.params.sources import KNOWN
from foggy_synscapes.schema import Section, facts_of, open_section, section_in
from foggy_synscapes.training.policy import Policy

DIALECT = "https://json-schema.org/draft/2020-12/schema"
HEAD = """\
# Parameters

Every key of a params file. `foggy params --docs` makes this page, and `foggy params --schema` the JSON Schema
`docs/params.schema.json` by which editors complete and check, both of the same source as the checks themselves.

A params file is an overlay on the packaged defaults: it states only what differs. Sections are merged key by key.
Lists, lengths (`images`, `epochs` or `iterations`) and mappings whose keys you name (the lists of `subset`,
`train.rows`) are replaced whole where the file states them. A file that names another of its folder as its `base` is
laid on that one first. `foggy params --file FILE` prints what comes of it, complete; `--check` says what does not fit
together.

| you want | do |
|---|---|
| run an overlay with Snakemake | `snakemake --cores 2 --configfile params/paper.yaml` |
| make it DVC's `params.yaml`, which has to be complete | `foggy params --file params/paper.yaml --out params.yaml` |
| have the defaults again | `foggy params --defaults --out params.yaml` |

In keys, `ROW` is a row that you name, `NETWORK` a network, and `[]` each entry of a list. Defaults that
differ from row to row or from network to network are listed with their names.
"""


class Key(NamedTuple):
    """A key of the params: its dotted name with placeholders, its field, and its own JSON Schema."""

    name: str
    field: FieldInfo
    schema: dict[str, Any]


def json_schema() -> str:
    """The JSON Schema of params files, as text. No section requires its keys, since overlays leave out what they do
    not change.
    """
    schema = model().model_json_schema(by_alias=True)
    about = "another params file, from the folder of this one, on which this one is laid"
    schema["properties"] = {"base": {"type": "string", "description": about}, **schema["properties"]}
    for definition in (schema, *(schema["$defs"][each.__name__] for each in _merged(model()))):
        definition.pop("required", None)
    return json.dumps({"$schema": DIALECT, **_untitled(schema)}, indent=2, ensure_ascii=False) + "\n"


def markdown(defaults: dict[str, Any]) -> str:
    """The page of all keys; `defaults` is a complete document."""
    lines, whole = HEAD.splitlines(), model().model_json_schema(by_alias=True)
    for top, field in model().model_fields.items():
        section = section_in(field.annotation)
        lines += ["", f"## {top}"]
        if section is not None:
            lines += [(section.__doc__ or "").strip().splitlines()[0]]
        lines += ["", "| key | unit | range | default | meaning, published value, source |", "|---|---|---|---|---|"]
        own = [Key(top, field, whole["properties"][top])] if section is None else keys(section, top, defaults)
        for key in own:
            cells = (f"`{key.name}`", unit(key.field), limits(key.schema), default(defaults, key.name))
            about = "; ".join(facts(key.field)).replace("|", "\\|")
            lines.append(f"| {' | '.join(cells)} | {about} |".replace("  ", " "))
    lines += ["", "## Of single rows and networks", "| key | published value, source |", "|---|---|"]
    lines += [f"| `{place}` | {known} |" for place, known in KNOWN.items()]
    return "\n".join(lines) + "\n"


def keys(section: type[Section], place: str, defaults: dict[str, Any]) -> Iterator[Key]:
    """All keys of a section and of the sections in it."""
    properties = section.model_json_schema(by_alias=True)["properties"]
    for name, field in section.model_fields.items():
        inner = f"{place}.{field.alias or name}"
        yield Key(inner, field, properties[field.alias or name])
        part, below = _below(field, inner)
        # A policy that no default states has the keys of those that are stated.
        if part is not None and not (part is Policy and not list(found(defaults, below))):
            yield from keys(part, below, defaults)
    extra = open_section(section)
    if extra is not None:
        yield from keys(extra, f"{place}.NETWORK", defaults)


def default(defaults: dict[str, Any], name: str) -> str:
    """Default of a key as a cell; by row or network where these differ."""
    stated = [(path, value) for path, value in found(defaults, name) if not isinstance(value, dict)]
    # Entries that are mappings have keys of their own.
    plain = [
        (path, flow(value)) for path, value in stated if not (isinstance(value, list) and dict in map(type, value))
    ]
    words = list(dict.fromkeys(word for _, word in plain))
    if len(words) > 1 and all(path for path, _ in plain):
        return ", ".join(f"{path[-1]} `{word}`" for path, word in plain)
    return ", ".join(f"`{word}`" for word in words)


def found(document: Any, name: str, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """What stands at a dotted key with placeholders, each with the names that the placeholders stand for."""
    first, _, rest = name.partition(".")
    listed = first.endswith("[]")
    first = first.removesuffix("[]")
    if not isinstance(document, dict):
        return
    steps = [(key, value) for key, value in document.items() if first.isupper() or key == first]
    for key, value in steps:
        here = (*path, key) if first.isupper() else path
        for each in value if listed else [value]:
            if rest:
                yield from found(each, rest, here)
            else:
                yield here, each


def _below(field: FieldInfo, place: str) -> tuple[type[Section] | None, str]:
    """The section that a field holds, also in a list or a mapping, and the place of its keys."""
    origin, parts = get_origin(field.annotation), get_args(field.annotation)
    if origin is dict:
        return section_in(parts[1]), f"{place}.{facts_of(field)['key']}"
    if origin is list:
        return section_in(parts[0]), f"{place}[]"
    return section_in(field.annotation), place


def _merged(section: type[Section]) -> set[type[Section]]:
    """Sections that an overlay may state in part."""
    found = {section_in(field.annotation) for field in section.model_fields.values()} | {open_section(section)}
    inner = {each for each in found if each is not None and not each.whole}
    return inner.union(*map(_merged, inner))


def _untitled(schema: Any) -> Any:
    """A schema without the titles that only repeat names."""
    if isinstance(schema, dict):
        return {key: _untitled(value) for key, value in schema.items() if key != "title"}
    return [_untitled(each) for each in schema] if isinstance(schema, list) else schema


def limits(schema: dict[str, Any]) -> str:
    """The range of a field in words, from its JSON Schema.

    >>> limits({"type": "integer", "minimum": 0, "maximum": 3}), limits({"type": "number", "exclusiveMinimum": 0})
    ('0 to 3', '> 0')
    """
    if "range" in schema:
        return schema["range"]
    if "anyOf" in schema:
        return ", or ".join(filter(None, map(limits, schema["anyOf"])))
    if "enum" in schema or "const" in schema:
        return ", ".join(map(str, schema.get("enum", [schema.get("const")])))
    if "prefixItems" in schema:
        each = list(map(limits, schema["prefixItems"]))
        return f"{len(each)} numbers {each[0]}" if len(set(each)) == 1 else " and ".join(each)
    kind = schema.get("type", "")
    if kind == "array":
        return f"list of: {limits(schema['items'])}" if "$ref" not in schema["items"] else "list"
    if kind in ("integer", "number"):
        return _between(schema) or ("whole number" if kind == "integer" else "number")
    return {"boolean": "true, false", "string": "text", "null": "null", "object": "mapping"}.get(kind, "mapping")


def _between(schema: dict[str, Any]) -> str:
    least, above = schema.get("minimum"), schema.get("exclusiveMinimum")
    most, below = schema.get("maximum"), schema.get("exclusiveMaximum")
    if least is not None and most is not None:
        return f"{least} to {most}"
    signs = ((">=", least), (">", above), ("<=", most), ("<", below))
    return ", ".join(f"{sign} {bound}" for sign, bound in signs if bound is not None)
