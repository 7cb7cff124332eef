"""The params of a job as its run record states them: the declared values, without folders of the machine."""

from collections.abc import Iterator
from typing import Any

from foggy_synscapes.params import STAND_IN, Params

REAL = "real"
IMPORTED = "imported"
NO_WEIGHTS = "none"


def recorded(params: Params, *keys: str) -> dict[str, Any]:
    """Values of dotted keys, nested as in the params file and spelt as in JSON.

    A dataset's folder becomes "real" and a file of weights "imported": what they hold is recorded by hashes.

    Raises KeyError if a key is not in the params.
    """
    return select(without_folders(params), *keys)


def without_folders(params: Params) -> dict[str, Any]:
    """All values of params as run records state them, nested as in the params file."""
    values = params.model_dump(mode="json", by_alias=True)
    roots = values["scenes"]["roots"]
    roots.update({name: REAL for name, folder in roots.items() if folder != STAND_IN})
    for settings in filter(_has_weights, values["train"].values()):
        settings["weights"] = IMPORTED if settings["weights"] != NO_WEIGHTS else NO_WEIGHTS
    for row in filter(None, values["train"]["rows"].values()):
        for start in row["start"].values():
            start["weights"] = IMPORTED if start["weights"] != NO_WEIGHTS else NO_WEIGHTS
    return values


def _has_weights(section: object) -> bool:
    """Whether a part of the section `train` is the settings of a network."""
    return isinstance(section, dict) and "weights" in section


def select(values: dict[str, Any], *keys: str) -> dict[str, Any]:
    """The part of nested values that dotted keys name; of a list, the named value of each of its entries.

    >>> select({"fog": {"betas": ["0.005"], "png_level": 0}, "rows": [{"row": "C"}]}, "fog.betas", "rows.row")
    {'fog': {'betas': ['0.005']}, 'rows': {'row': ['C']}}
    """
    chosen: dict[str, Any] = {}
    for key in keys:
        source: Any = values
        target = chosen
        *outer, last = key.split(".")
        for part in outer:
            source, target = source[part], target.setdefault(part, {})
        target[last] = [entry[last] for entry in source] if isinstance(source, list) else source[last]
    return chosen


def leaves(values: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Dotted keys and values of what is no mapping, in the order of the keys.

    >>> dict(leaves({"fog": {"frames": {"first": 2}}}))
    {'fog.frames.first': 2}
    """
    for key, value in values.items():
        if isinstance(value, dict):
            yield from leaves(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value
