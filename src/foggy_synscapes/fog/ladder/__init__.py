"""How far each fog model is off at most, as the atlas found it: what `auto` decides by.

The mean error of a frame grows with the share of light that fog takes from it, so the bound is that share times a
factor, the largest of the frames that it was fitted on. `foggy atlas` makes the factors, and scores them on others.
"""

import csv
import io
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

import numpy as np

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.fog.geometry import Rays
from foggy_synscapes.io.files import read_bytes

FILE = Path(__file__).with_name("bounds.csv")
COLUMNS = ("surround", "model", "beta", "factor")
DIMMED = "dimmed"
RUNGS = ("none", "homogeneous", DIMMED, "surround")
"""Models of homogeneous air, cheapest first; dimmed: homogeneous, with an airlight below the surround's."""
SHARE = {"open": 0.8, "ground": 0.6}
"""Times the airlight's levels, where it is dimmed, by surround; as `foggy atlas` fits them."""
SEEN = 4
"""Of rows and columns every so many are looked at: means of a frame hardly change by it."""

Factors = Mapping[tuple[str, str], tuple[tuple[float, ...], tuple[float, ...]]]
"""By surround and model: betas in 1/m, ascending, and levels per share of lost light."""


@cache
def factors(file: Path = FILE) -> Factors:
    """The atlas' factors; FoggyError where there is no atlas, or the file is none."""
    advice = "A tolerance needs an atlas: foggy atlas makes it, as results/atlas/bounds.csv."
    text = read_bytes(file, "atlas of fog models", advice).decode("utf-8", "replace")
    found: dict[tuple[str, str], dict[float, float]] = {}
    try:
        for line in csv.DictReader(io.StringIO(text)):
            found.setdefault((line["surround"], line["model"]), {})[float(line["beta"])] = float(line["factor"])
    except (KeyError, TypeError, ValueError) as error:
        raise FoggyError(f"{file}: no atlas of fog models, expected columns {', '.join(COLUMNS)}. {advice}") from error
    return {key: (tuple(sorted(by)), tuple(by[beta] for beta in sorted(by))) for key, by in found.items()}


def lost(depth: np.ndarray, rays: Rays, beta: float) -> float:
    """Share of a frame's light that fog takes: the mean of 1 - t.

    depth : float32 (H, W), planar metres; beta : 1/m

    >>> from foggy_synscapes.fog.geometry import straight
    >>> lost(np.array([[0.0, np.inf]], np.float32), straight((1, 2)), 0.02)
    0.5
    """
    if beta == 0:
        return 0.0
    part = Rays(rays.rows[::SEEN], rays.columns[::SEEN], rays.scale)
    if min(depth.shape) < 8 * SEEN:
        part, seen = rays, depth
    else:
        seen = depth[::SEEN, ::SEEN]
    return float(-np.expm1(-beta * (seen * part.factor())).mean())


def dimmed(light: Sequence[int], surround: str) -> list[int]:
    """An airlight's levels, dimmed.

    >>> dimmed((250, 255, 245), "open")
    [200, 204, 196]
    """
    return [round(SHARE[surround] * int(level)) for level in light]


def bound(model: str, surround: str, beta: float, share: float, known: Factors) -> float:
    """Levels that a model is off at most in the mean over a frame that loses such a share of its light.

    Between the atlas' betas factors are interpolated; beyond them they are those of the last one.

    Raises ValueError where the atlas knows no such model or surround.
    """
    if (surround, model) not in known:
        raise ValueError(f"the atlas has no {model} fog with surround {surround!r}; it has {sorted(known)}")
    betas, values = known[surround, model]
    return share * float(np.interp(beta, betas, values))
