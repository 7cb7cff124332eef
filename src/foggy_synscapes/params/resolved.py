"""The complete params as YAML, each value with its meaning, unit and source beside it."""

import re
import textwrap
from collections.abc import Iterator
from decimal import Decimal
from typing import Any, Literal, get_args, get_origin

import yaml
from pydantic.fields import FieldInfo

from foggy_synscapes.params.experiment import Params
from foggy_synscapes.params.sources import KNOWN
from foggy_synscapes.schema import Section, facts_of, members, open_section

WIDTH = 120
PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_./ +-]*")
HEAD = """\
# yaml-language-server: $schema=docs/params.schema.json
# What is run, complete: each value with its meaning, unit and source; all keys with their ranges: docs/parameters.md.
# Edit it, or write a file that states only what differs from the packaged defaults, as those in params/ do. Run that by
# snakemake --configfile FILE; for DVC, which needs a complete file: foggy params --file FILE --out params.yaml
"""


def text(params: Params) -> str:
    """The YAML text of params; reading it gives equal params."""
    lines = HEAD.splitlines()
    for key, field, value in _entries(params):
        lines += ["", *_entry(key, field, value, key, 0)]
    return "\n".join(lines) + "\n"


def document(params: Params) -> dict[str, Any]:
    """What `text` writes, as plain data."""
    return yaml.safe_load(text(params))


def _entries(section: Section) -> Iterator[tuple[str, FieldInfo | None, Any]]:
    """Key, field and value of what is written of a section: not what may be left out and is at its default."""
    for name, field in type(section).model_fields.items():
        value = getattr(section, name)
        left_out = value is None or (value == {} and section.inline)  # an empty section would be that of the defaults
        if not (left_out and not field.is_required()):
            yield field.alias or name, field, value
    if open_section(type(section)) is not None:
        yield from ((key, None, value) for key, value in (section.__pydantic_extra__ or {}).items())


def _entry(key: str, field: FieldInfo | None, value: Any, place: str, indent: int) -> list[str]:
    return _value(key, value, comment(field) if field is not None else [], place, indent)


def _value(key: str, value: Any, words: list[str], place: str, indent: int) -> list[str]:
    about = "; ".join([*words, *filter(None, [KNOWN.get(place)])])
    inner = indent + 2
    begin = f"{' ' * indent}{scalar(key)}:"
    if isinstance(value, Section) and not _fits(value, len(begin)):
        return _commented(begin, about, indent) + [
            line
            for name, field, each in _entries(value)
            for line in _entry(name, field, each, f"{place}.{name}", inner)
        ]
    if isinstance(value, dict) and value:
        lines = [line for name, each in value.items() for line in _value(name, each, [], f"{place}.{name}", inner)]
        return _commented(begin, about, indent) + lines
    if isinstance(value, list) and value and isinstance(value[0], Section):
        return _commented(begin, about, indent) + [f"{' ' * inner}- {flow(each)}" for each in value]
    written = flow(value)
    if len(begin) + len(written) >= WIDTH:
        wrapped = textwrap.wrap(written[1:-1], WIDTH - inner - 1, break_long_words=False, break_on_hyphens=False)
        wrapped[-1] += "]"
        return _commented(f"{begin} [", about, indent) + [" " * inner + line for line in wrapped]
    return _commented(f"{begin} {written}", about, indent)


def _fits(section: Section, before: int) -> bool:
    """Whether a section, and all in it, is one to be written on one line and short enough for that."""
    return _is_inline(section) and before + len(flow(section)) < WIDTH


def _is_inline(value: Any) -> bool:
    if isinstance(value, Section):
        return value.inline and all(_is_inline(each) for _, _, each in _entries(value))
    return not isinstance(value, dict)


def _commented(line: str, about: str, indent: int) -> list[str]:
    """A line with what is said about it behind it, or above it where that is too long."""
    if not about:
        return [line]
    if len(line) + len(about) + 4 <= WIDTH:
        return [f"{line}  # {about}"]
    above = textwrap.wrap(about, WIDTH - indent - 2, break_long_words=False, break_on_hyphens=False)
    return [*(f"{' ' * indent}# {part}" for part in above), line]


def flow(value: Any) -> str:
    """A value on one line.

    >>> flow({"crop": [600, 600], "betas": ["0.005"], "rate": 5e-5})
    '{crop: [600, 600], betas: ["0.005"], rate: 0.00005}'
    """
    if isinstance(value, Section):
        value = {key: each for key, _, each in _entries(value)}
    if isinstance(value, dict):
        return "{" + ", ".join(f"{scalar(key)}: {flow(each)}" for key, each in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(flow, value)) + "]"
    return scalar(value)


def scalar(value: str | int | float | bool | None) -> str:
    """A word or a number as YAML reads it back; a number without exponent, which YAML 1.1 would take for a word."""
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    if isinstance(value, float):
        written = f"{Decimal(repr(value)):f}"
        return written if "." in written else f"{written}.0"
    if isinstance(value, int):
        return str(value)
    if PLAIN.fullmatch(value) and yaml.safe_load(value) == value:
        return value
    return yaml.safe_dump(value, default_style='"', width=float("inf"), allow_unicode=False).strip()


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
