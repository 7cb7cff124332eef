"""Values that a fog model may be told, each with its meaning, unit and range where it is defined."""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, fields
from typing import Any

from foggy_synscapes.fog.airlight import GREY

WORDS = {"ge": "at least", "gt": "above", "le": "at most", "lt": "below"}
"""Limits of a value, by their names."""


def value(meaning: str, default: Any, unit: str = "", **limits: Any) -> Any:
    """A field of `Settings`.

    meaning : what it decides; default : its type is that of the value; None, of a number that may be left to the model
    limits : of a number, by the names in WORDS; of a word, `choices`
    """
    return field(default=default, metadata={"meaning": meaning, "unit": unit, **limits})


def allowed(facts: Any) -> str:
    """The range of a field in words.

    >>> allowed({"ge": 0, "lt": 60})
    'at least 0, below 60'
    """
    if "choices" in facts:
        return " or ".join(facts["choices"])
    return ", ".join(f"{word} {facts[key]:g}" for key, word in WORDS.items() if key in facts)


@dataclass(frozen=True)
class Settings:
    """What every model may be told.

    Raises ValueError, naming the range, where a value is out of it.
    """

    airlight: str | Sequence[int] = value(
        "estimated: from the image, as the published code does; grey: the same without its colour; or stated: the "
        "radiance of what surrounds the scene, in levels of red, green and blue",
        "estimated",
    )

    def __post_init__(self) -> None:
        _check_airlight(self.airlight)
        for each in fields(self):
            if each.name != "airlight":
                _check(each.name, getattr(self, each.name), each.default, each.metadata)

    def values(self) -> dict[str, Any]:
        """All values by name; numbers that stand for whole ones are equal to them."""
        return asdict(self)

    def light(self, estimated: Sequence[int]) -> tuple[int, ...]:
        """Airlight to use, three levels, where the image's is `estimated`.

        >>> Settings(airlight="grey").light((150, 190, 235))
        (183, 183, 183)
        """
        if self.airlight == "estimated":
            return tuple(estimated)
        if self.airlight == "grey":
            total = sum(weight * int(level) for weight, level in zip(GREY, estimated, strict=True))
            return ((total + 500_000_000) // 10**9,) * 3
        return tuple(int(level) for level in self.airlight)


def _check_airlight(light: Any) -> None:
    if light in ("estimated", "grey"):
        return
    is_colour = isinstance(light, list | tuple) and len(light) == 3
    if not is_colour or not all(isinstance(level, int) and 0 <= level <= 255 for level in light):
        raise ValueError(f"airlight is {light}, expected estimated, grey or three levels from 0 to 255")


def _check(name: str, found: Any, default: Any, facts: Any) -> None:
    unit = f" {facts['unit']}" if facts["unit"] else ""
    if "choices" in facts:
        right = found in facts["choices"]
    elif found is None:
        right = default is None
    else:
        kind = int if isinstance(default, int) else int | float
        right = isinstance(found, kind) and not isinstance(found, bool) and math.isfinite(found)
        right = right and not (
            ("ge" in facts and found < facts["ge"])
            or ("gt" in facts and found <= facts["gt"])
            or ("le" in facts and found > facts["le"])
            or ("lt" in facts and found >= facts["lt"])
        )
    if not right:
        whole = "a whole number, " if isinstance(default, int) else ""
        raise ValueError(f"{name} is {found}{unit}, expected {whole}{allowed(facts)}{unit}")
