"""What the atlas shows: one frame in every model beside the reference, and its findings in words and tables."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from foggy_synscapes.atlas.cells import OPEN, SIDE_BETA, Cell
from foggy_synscapes.atlas.errors import Rung, along, difference, made
from foggy_synscapes.atlas.scenes import scene
from foggy_synscapes.atlas.store import BLOCK, Scattered
from foggy_synscapes.fog.radiance import encoded, linear

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHOWN = 0
"""Frame that is shown."""
FULL = 64.0
"""Levels of difference that are drawn in full colour."""
CORE = ["surround", "beta"]
OUTSIDE = "outside the frame"


def figure(rungs: Mapping[str, Sequence[Rung]], found: dict[Cell, Scattered]) -> "Figure":
    """The same frame in every model, by surround, and below each its difference to the reference."""
    from foggy_synscapes.figures.panels import grid

    clear = scene(SHOWN).image
    lines, notes = [], []
    for beyond, shown in rungs.items():
        cell = Cell(SHOWN, SIDE_BETA, beyond)
        traced = painted(cell, found[cell])
        offs = [difference(rung, cell, found[cell]) for rung in shown]
        lines += [[clear, traced, *(made(rung, cell) for rung in shown)]]
        blank = np.full_like(clear, 255)
        lines += [[blank, blank, *(signed(off, clear.shape[:2]) for off in offs)]]
        notes += [[""] * (len(shown) + 2), ["", "", *(f"{np.abs(off).mean():.1f} levels" for off in offs)]]
    rows = [row for beyond in rungs for row in (beyond, "difference")]
    heads = ["clear", "path tracing", *(rung.name for rung in next(iter(rungs.values())))]
    return grid(lines, heads, rows, notes)


def painted(cell: Cell, scattered: Scattered) -> np.ndarray:
    """The reference as an image, uint8 (H, W, 3): its direct light of each pixel, its scattered light of blocks.

    Between the middles of blocks scattered light is interpolated, relative to the light that fog takes from a pixel, so
    that depth edges are as sharp as they are in the scattered light.
    """
    found, way = scene(cell.frame), along(scene(cell.frame))
    beyond = found.surround(cell.surround)
    t = np.exp(-cell.beta * found.depth * way.factor())[..., None]
    height, width = found.depth.shape
    lost = (1 - t).reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, 1).mean(axis=(1, 3))
    share = _smooth(scattered.mean / np.maximum(lost, 1e-3), height, width)
    return np.rint(encoded(beyond + t * (linear(found.image) - beyond) + (1 - t) * share)).astype(np.uint8)


def _smooth(values: np.ndarray, height: int, width: int) -> np.ndarray:
    """Bilinear between the middles of blocks, (H, W, C) of (h, w, C)."""
    for axis, size in ((0, height), (1, width)):
        at = np.clip((np.arange(size) + 0.5) / BLOCK - 0.5, 0, values.shape[axis] - 1)
        low = np.minimum(at.astype(int), values.shape[axis] - 2)
        part = (at - low).reshape([-1 if each == axis else 1 for each in range(3)])
        values = np.take(values, low, axis) * (1 - part) + np.take(values, low + 1, axis) * part
    return values


def signed(off: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Differences of blocks as colours: red where the model is too bright, blue where too dark, white where right."""
    mean = np.clip(off.mean(axis=-1) / FULL, -1, 1)
    mean = np.repeat(np.repeat(mean, BLOCK, 0), BLOCK, 1)[: shape[0], : shape[1]]
    red, blue = np.minimum(1 + mean, 1), np.minimum(1 - mean, 1)
    return np.rint(255 * np.stack([red, np.minimum(red, blue), blue], axis=-1)).astype(np.uint8)


def core(errors: pd.DataFrame, fitted: bool | None = None) -> pd.DataFrame:
    """Mean error in levels by surround and beta; `fitted`: on the frames that were, or were not, fitted on."""
    from foggy_synscapes.atlas.cells import ALBEDO, ASYMMETRY, SKY

    same = (errors["albedo"] == ALBEDO) & (errors["asymmetry"] == ASYMMETRY) & (errors["height"] == 0)
    here = errors[same & (errors["surround"] != SKY) & (errors["airlight"] == "estimated")]
    if fitted is not None:
        here = here[(here["frame"] % 2 == 0) == fitted]
    wide = here.pivot_table(index=CORE, columns="model", values="mean", sort=False)
    return wide.rename_axis(index={"surround": OUTSIDE}).reset_index()


def by_distance(errors: pd.DataFrame, bins: Sequence[str]) -> pd.DataFrame:
    """Mean error in levels by distance, of each model in open surround."""
    from foggy_synscapes.atlas.cells import ALBEDO, ASYMMETRY

    same = (errors["albedo"] == ALBEDO) & (errors["asymmetry"] == ASYMMETRY) & (errors["height"] == 0)
    here = errors[same & (errors["surround"] == OPEN) & (errors["airlight"] == "estimated")]
    return here.groupby(["beta", "model"], sort=False)[list(bins)].mean().reset_index()


def changes(errors: pd.DataFrame) -> pd.DataFrame:
    """Mean error where one thing is other than in fog: how it scatters, what surrounds the frame, or its height."""
    from foggy_synscapes.atlas.cells import ALBEDO, ASYMMETRY, SKY

    same = (errors["albedo"] == ALBEDO) & (errors["asymmetry"] == ASYMMETRY) & (errors["height"] == 0)
    plain = (errors["frame"] == SHOWN) & (errors["beta"] == SIDE_BETA) & (errors["surround"] == OPEN)
    here = errors[~same | (errors["surround"] == SKY) | (same & plain)]
    keys = ["surround", "albedo", "asymmetry", "height", "airlight"]
    wide = here.pivot_table(index=keys, columns="model", values="mean", sort=False)
    return wide.rename_axis(index={"surround": OUTSIDE}).reset_index()
