"""How far each fog model is from the reference, in levels of 8 bits."""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd

from foggy_synscapes.atlas.cells import GROUND, Cell
from foggy_synscapes.atlas.multiple_scattering import foggy as multiply_scattered
from foggy_synscapes.atlas.scenes import Scene, scene
from foggy_synscapes.atlas.store import Scattered, blocks
from foggy_synscapes.fog import models, uneven
from foggy_synscapes.fog.geometry import Rays, rays
from foggy_synscapes.fog.radiance import encoded, linear

DISTANCES = (0.0, 15.0, 40.0, np.inf)
"""Metres between which errors are told apart; the sky is in the last range."""
SURROUND, ESTIMATED = "surround", "estimated"
SERIES = "Narasimhan-Nayar series"
COLUMNS = ("frame", "beta", "surround", "albedo", "asymmetry", "height", "model", "airlight", "mean", "bias")
BINS = tuple(
    f"{low:g} to {high:g} m" if np.isfinite(high) else f"{low:g} m and more" for low, high in pairwise(DISTANCES)
)


@dataclass(frozen=True)
class Rung:
    """A way of making fog that is scored.

    name : how tables call it; model : spelling, for open surround and for ground; airlight : ESTIMATED or SURROUND
    dimmed : times the airlight's levels, stated instead of the estimated ones
    """

    name: str
    model: str
    airlight: str = ESTIMATED
    dimmed: float = 1.0

    def spelt(self, cell: Cell, light: Iterable[int]) -> str:
        """The model at a cell's own values."""
        values = dict(models.values_of(self.model)[1])
        name = models.values_of(self.model)[0]
        if name == "surround" and values.get("share") != 0 and cell.surround == GROUND:
            values["surround"] = GROUND
        if name == "layered" and cell.height:
            values["scale_height"] = cell.height
        if self.airlight == SURROUND:
            values["airlight"] = [*light]
        elif self.dimmed != 1:
            values["airlight"] = [round(self.dimmed * level) for level in scene(cell.frame).airlight]
        return models.spelling(name, values)


def along(found: Scene) -> Rays:
    """Rays of a scene, as the reference has them."""
    return rays(found.camera, "exact")


def reference(cell: Cell, scattered: Scattered) -> np.ndarray:
    """The foggy frame that the reference gives, as means over blocks: levels, float64 (h, w, 3)."""
    found, way = scene(cell.frame), along(scene(cell.frame))
    beyond = found.surround(cell.surround)
    if cell.height:
        distance = uneven.layered(found.depth, way, cell.height, found.height, found.pitch)
    else:
        distance = found.depth * way.factor()
    t = np.exp(-cell.beta * distance)[..., None]
    return encoded(blocks(beyond + t * (linear(found.image) - beyond)) + scattered.mean)


def made(rung: Rung, cell: Cell) -> np.ndarray:
    """The foggy frame of a rung, uint8 (H, W, 3)."""
    found, way = scene(cell.frame), along(scene(cell.frame))
    if rung.name == SERIES:
        distance = found.depth * way.factor()
        return multiply_scattered(found.image, distance, cell.beta, found.surround(cell.surround), found.camera.fx)
    light = np.rint(encoded(found.surround(cell.surround))).astype(int).tolist()
    spelt = rung.spelt(cell, light)
    if rung.model.partition(":")[0] == "layered":
        values: dict[str, Any] = {"camera_height": found.height, "pitch": found.pitch}
        return models.apply(spelt, found.image, found.depth, cell.beta, way, airlight=found.airlight, **values)
    return models.apply(spelt, found.image, found.depth, cell.beta, way, airlight=found.airlight)


def difference(rung: Rung, cell: Cell, scattered: Scattered) -> np.ndarray:
    """A rung's block means minus the reference's, in levels: float64 (h, w, 3)."""
    return encoded(blocks(linear(made(rung, cell)))) - reference(cell, scattered)


def row(rung: Rung, cell: Cell, scattered: Scattered) -> dict[str, object]:
    """Mean absolute difference, mean difference, and the former by distance, in levels."""
    off = difference(rung, cell, scattered)
    found = scene(cell.frame)
    metres = blocks((found.depth * along(found).factor())[..., None])[..., 0]
    named: dict[str, object] = {**vars(cell), "model": rung.name, "airlight": rung.airlight}
    named |= {"mean": float(np.abs(off).mean()), "bias": float(off.mean())}
    for name, low, high in zip(BINS, DISTANCES, DISTANCES[1:], strict=False):
        here = (metres >= low) & (metres < high)
        named[name] = float(np.abs(off[here]).mean()) if here.any() else float("nan")
    return named


def table(rungs: Iterable[Rung], found: dict[Cell, Scattered]) -> pd.DataFrame:
    """All rungs at all cells."""
    return pd.DataFrame(
        [row(rung, cell, one) for cell, one in found.items() for rung in rungs], columns=[*COLUMNS, *BINS]
    )


def noise(found: dict[Cell, Scattered]) -> float:
    """Standard error of the reference in levels: of a block, in the mean over cells, at the slope of mid-grey."""
    middle = 0.2
    slope = float((encoded(np.array(middle + 1e-4)) - encoded(np.array(middle - 1e-4))) / 2e-4)
    return slope * float(np.mean([one.error for one in found.values()]))
