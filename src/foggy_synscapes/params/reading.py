"""Reading a params file: an overlay on the packaged defaults, which states only what differs from them.

Sections are merged key by key. Lists, lengths (images, epochs or iterations) and mappings whose keys the user names
(the lists of `subset`, `train.rows`) are replaced whole where the overlay states them. A complete file is an overlay
that states everything. A file may name another as its `base`, on which it is laid first. The working params.yaml is no
part of it: a user edits that.
"""

import difflib
from decimal import Decimal
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.plain_yaml import read_yaml
from foggy_synscapes.networks import NETWORKS
from foggy_synscapes.params.experiment import Params, model
from foggy_synscapes.params.resolved import document
from foggy_synscapes.params.training import Train
from foggy_synscapes.registry import use_plugins
from foggy_synscapes.schema import Section, is_merged, open_section, section_at, sections

DEFAULTS = Path(__file__).with_name("defaults.yaml")
BASE = "base"
"""Key of a params file that names another, on which it is laid."""


def load(path: str | Path) -> Params:
    """Read and check a params file.

    Raises FoggyError naming the file and the key that is missing, misspelt, twice, of a wrong type, impossible or
    contradicted.
    """
    return check(_stated(Path(path)), str(path))


def check(stated: dict[str, Any], name: str) -> Params:
    """Check what a params file states; `name` stands for it in messages.

    Its plugins are those that registries find from now on.
    """
    plugins = {**_defaults(), **stated}["plugins"]
    if plugins is None or isinstance(plugins, str):
        try:
            use_plugins(plugins)
        except FoggyError as error:
            raise FoggyError(f"{name}: {error}") from error
    schema = model()
    whole = overlaid(_defaults(), stated, schema)
    problems = []
    if isinstance(whole["train"], dict):
        # Keys of this section that are none of its fields name networks; any other is a slip.
        known = {*_keys(Train), *NETWORKS.names()}
        unknown = [key for key in whole["train"] if key not in known]
        problems = [f"train.{key}: unknown key{_suggest(key, known)}" for key in unknown]
        whole["train"] = {key: value for key, value in whole["train"].items() if key in known}
    try:
        params = schema.model_validate(whole)
    except ValidationError as error:
        problems += [_explain(problem) for problem in error.errors()]
    if problems:
        raise FoggyError("\n".join(f"{name}: {problem}" for problem in problems))
    return params


def overlaid(base: dict[str, Any], overlay: dict[str, Any], section: type[Section]) -> dict[str, Any]:
    """A section's values with those that an overlay states in their place; neither document is changed."""
    values = dict(base)
    for key, value in overlay.items():
        inner = section_at(section, key) if isinstance(key, str) else None
        both = isinstance(value, dict) and isinstance(values.get(key), dict)
        if both and inner is not None and not inner.whole:
            values[key] = overlaid(values[key], value, inner)
        else:
            values[key] = {**values[key], **value} if both and is_merged(section, key) else value
    return values


def require_complete(path: str | Path) -> None:
    """Refuse a file that DVC could not read as it stands, because it leaves values to the packaged defaults.

    Raises
    ------
    FoggyError
        As `load` does, or naming the first key that the file leaves out and how to complete it.
    """
    stated, whole = _read(path), document(load(path))
    left_out = _left_out(stated, whole)
    if left_out:
        raise FoggyError(
            f"{path}: leaves {left_out[0]} to the packaged defaults ({len(left_out)} such keys), but DVC reads this "
            f"file as it stands. Complete it: foggy params --file {path} --out {path}"
        )


def _stated(path: Path, *above: Path) -> dict[str, Any]:
    """What a file states, laid on what the file states that it names as its `base`, from its own folder."""
    stated = _read(path)
    base = stated.pop(BASE, None)
    if base is None:
        return stated
    if not isinstance(base, str) or (path.parent / base).resolve() in (path.resolve(), *above):
        raise FoggyError(f"{path}: {BASE}: name another params file, from the folder of this one; got {base!r}")
    return overlaid(_stated(path.parent / base, path.resolve(), *above), stated, model())


def _read(path: str | Path) -> dict[str, Any]:
    stated = read_yaml(path)
    if not isinstance(stated, dict):
        raise FoggyError(
            f"{path}: expected sections such as scenes, fog and train, or {{}} for the defaults; got "
            f"{'an empty file' if stated is None else type(stated).__name__}"
        )
    return stated


@cache
def _defaults() -> dict[str, Any]:
    return read_yaml(DEFAULTS)


def _left_out(stated: dict[str, Any], whole: dict[str, Any], place: str = "") -> list[str]:
    """Dotted keys of a complete document that another one lacks, the outermost of each."""
    names = [place + key for key in whole if key not in stated]
    for key, value in whole.items():
        if isinstance(value, dict) and isinstance(stated.get(key), dict):
            names += _left_out(stated[key], value, f"{place}{key}.")
    return names


def _explain(problem: ErrorDetails) -> str:
    place = ".".join(str(part) for part in problem["loc"]) or "the whole file"
    kind, message = problem["type"], problem["msg"].removeprefix("Value error, ")
    if kind == "extra_forbidden":
        return f"{place}: unknown key{_suggest(str(problem['loc'][-1]), _all_keys(model()))}"
    if kind == "missing":
        return f"{place}: missing. It has no default, so state it; docs/parameters.md lists all keys."
    if kind == "value_error":
        return f"{place}: {message}"
    value = problem["input"]
    if kind == "string_type" and isinstance(value, int | float) and not isinstance(value, bool):
        # Betas and seeds are names of folders: as numbers, 0.010 and 1e-2 would be one value and two names.
        return f'{place}: a number; write it in quotes, "{_spelt(value)}", as it stands in names of folders'
    return f"{place}: {message}; got {value!r}"


def _spelt(value: float) -> str:
    """A number as names of folders have it.

    >>> _spelt(0.005), _spelt(1e-05), _spelt(3)
    ('0.005', '0.00001', '3')
    """
    return str(value) if isinstance(value, int) else f"{Decimal(repr(value)):f}"


def _suggest(key: object, known: set[str]) -> str:
    close = difflib.get_close_matches(str(key), sorted(known), n=1)
    return (f"; did you mean {close[0]}?" if close else ".") + " Remove it or correct its spelling."


def _keys(model: type[Section]) -> set[str]:
    return {field.alias or name for name, field in model.model_fields.items()}


def _all_keys(model: type[Section]) -> set[str]:
    """Keys of a section and of all sections in it."""
    inner = {each for field in model.model_fields.values() for each in sections(field.annotation)}
    opened = open_section(model)
    return _keys(model).union(*map(_all_keys, [*inner, opened] if opened else inner))
