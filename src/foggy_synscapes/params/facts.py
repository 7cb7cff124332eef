"""What the schema says of a field, in words for a comment or a table."""

from typing import Any, Literal, get_args, get_origin

from pydantic.fields import FieldInfo

from foggy_synscapes.schema import facts_of, members


def facts(field: FieldInfo) -> list[str]:
    """Meaning, published value and source of a field, as phrases."""
    extra = facts_of(field)
    published = f"published: {extra['published']}" if "published" in extra else None
    return [fact for fact in (field.description, published, extra.get("source")) if fact]


def unit(field: FieldInfo) -> str:
    """Unit of a field; empty where it has none."""
    return facts_of(field).get("unit", "")


def comment(field: FieldInfo) -> list[str]:
    """Unit and facts as phrases; before them the choices, where the meaning does not name each."""
    first, *rest = facts(field) or [""]
    begin = [" | ".join(choices(field))] if any(choice not in first for choice in choices(field)) else []
    return [*begin, *filter(None, [f"{unit(field)}, {first}" if unit(field) else first]), *rest]


def choices(field: FieldInfo) -> list[str]:
    """The values that a field may have, where its type lists them.

    >>> choices(FieldInfo(annotation=Literal["poly", "constant"]))
    ['poly', 'constant']
    """
    return [str(value) for part in members(field.annotation) if get_origin(part) is Literal for value in get_args(part)]


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
