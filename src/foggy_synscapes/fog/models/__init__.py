"""Models of fog: each a module that declares one, here or among the plugins.

A model is spelt `NAME`, or `NAME:KEY=VALUE,...` where values differ from its defaults, such as
`layered:scale_height=10`: so on the command line, in records, recipes and captions.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from foggy_synscapes.camera import Camera
from foggy_synscapes.fog.airlight import estimate
from foggy_synscapes.fog.geometry import Rays, rays
from foggy_synscapes.fog.models.model import Choice, FogModel, Settings, with_settings
from foggy_synscapes.registry import Registry

__all__ = ["MODELS", "Choice", "FogModel", "Settings", "apply", "chosen", "spelling", "spelt", "values_of"]

MODELS: Registry[FogModel] = Registry("fog.models", "FOG_MODEL", "fog model")


def apply(
    model: str,
    image: np.ndarray,
    depth: np.ndarray,
    beta: float | Sequence[float],
    camera: Camera | Rays,
    *,
    airlight: Sequence[int] | None = None,
    geometry: str = "paper",
    **values: Any,
) -> np.ndarray:
    """Fog on one image by any model: uint8 (H, W, 3), or (B, H, W, 3) at several betas.

    Parameters
    ----------
    model : a name or spelling, see above; values : of its settings, by name
    image : uint8 (H, W, 3); depth : float32 (H, W), planar metres, at least 0
    beta : attenuation coefficient or several, 1/m, at least 0
    camera : of the image, or its rays; geometry : "paper" or "exact", see `fog.geometry.rays`
    airlight : three levels, 0 to 255; None: estimated from the image

    Raises FoggyError if there is no such model, ValueError naming the range if a value is out of it, and ValueError as
    `optics.foggy_images` does.

    >>> image = np.full((2, 2, 3), 100, np.uint8)
    >>> camera = Camera(fx=1e9, fy=1e9, u0=1.0, v0=1.0, resx=2, resy=2)
    >>> apply("homogeneous", image, np.full((2, 2), 69.3147, np.float32), 0.01, camera, airlight=(200, 200, 200))[0, 0]
    array([150, 150, 150], dtype=uint8)
    """
    found = chosen(spelling(*_joined(model, values)))
    along = camera if isinstance(camera, Rays) else rays(camera, geometry)
    light = estimate(image).levels if airlight is None else tuple(airlight)
    several = isinstance(beta, Sequence | np.ndarray)
    betas = [float(each) for each in np.atleast_1d(np.asarray(beta, float))]
    foggy = found.images(image, depth, along, light, betas)
    return foggy if several else foggy[0]


def chosen(text: str) -> FogModel:
    """The model of a spelling; UnknownEntry if there is none, ValueError naming the range if a value is out of it."""
    name, values = values_of(text)
    model = MODELS[name]
    return with_settings(model, _checked(name, model, values))


def values_of(text: str) -> tuple[str, dict[str, Any]]:
    """Name and values of a spelling; ValueError if it is none.

    >>> values_of("layered:scale_height=10,airlight=200/210/220")
    ('layered', {'scale_height': 10, 'airlight': [200, 210, 220]})
    """
    name, separator, rest = text.partition(":")
    values: dict[str, Any] = {}
    for part in rest.split(",") if separator else []:
        key, equals, value = part.partition("=")
        if not equals or not key or key in values:
            raise ValueError(f"{text!r}: expected NAME or NAME:KEY=VALUE,KEY=VALUE, each key once")
        values[key] = [_number(each) for each in value.split("/")] if "/" in value else _number(value)
    return name, values


def spelling(name: str, values: Mapping[str, Any]) -> str:
    """The one spelling of a model at these values: those that differ from the defaults, sorted.

    Raises as `chosen` does.

    >>> spelling("layered", {"scale_height": 10})
    'layered:scale_height=10'
    >>> spelling("homogeneous", {"airlight": "estimated"})
    'homogeneous'
    """
    model = MODELS[name]
    settings, usual = _checked(name, model, values).values(), model.settings().values()
    parts = [f"{key}={_text(settings[key])}" for key in sorted(settings) if settings[key] != usual[key]]
    return name + (":" + ",".join(parts) if parts else "")


def spelt(text: str) -> str:
    """The one spelling of what is spelt in any way; raises as `chosen` does.

    >>> spelt("layered:scale_height=20.0,pitch=0")
    'layered:pitch=0'
    """
    return spelling(*values_of(text))


def _joined(text: str, values: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    name, stated = values_of(text)
    return name, {**stated, **values}


def _checked(name: str, model: FogModel, values: Mapping[str, Any]) -> Settings:
    known = model.settings().values()
    for key in values:
        if key not in known:
            raise ValueError(f"fog model {name}: no value {key!r}; there are {', '.join(known)}")
    try:
        return model.settings(**values)
    except ValueError as error:
        raise ValueError(f"fog model {name}: {error}") from error


def _number(text: str) -> Any:
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def _text(value: Any) -> str:
    if isinstance(value, list | tuple):
        return "/".join(_text(each) for each in value)
    return f"{value:.12g}" if isinstance(value, float) else str(value)
