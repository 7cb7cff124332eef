"""What is fitted to the reference, on half of the frames, and how it does on the other half."""

from collections.abc import Sequence
from itertools import product

import numpy as np
import pandas as pd

from foggy_synscapes.atlas.cells import BETAS, GROUND, OPEN, Cell
from foggy_synscapes.atlas.errors import Rung, along, difference, made, reference
from foggy_synscapes.atlas.scenes import scene
from foggy_synscapes.atlas.store import Scattered, blocks
from foggy_synscapes.fog import ladder
from foggy_synscapes.fog.radiance import encoded, linear

BLURS = (2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0)
"""Degrees that are tried, and shares."""
SHARES = (0.5, 0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9, 0.95, 1.0)
DIMMED = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
"""Times the airlight's levels."""


def is_fitted(frame: int) -> bool:
    """Whether a frame is of the half that is fitted on."""
    return frame % 2 == 0


def surround(found: dict[Cell, Scattered], beyond: str) -> tuple[float, float]:
    """Share and blur, in degrees, of the model `surround` with the smallest mean error on the fitted frames."""
    fitted = [cell for cell in found if cell.is_core and cell.surround == beyond and is_fitted(cell.frame)]
    off = np.zeros((len(SHARES), len(BLURS)))
    for cell in fitted:
        exact = reference(cell, found[cell])
        none = blocks(linear(made(Rung("surround", "surround:share=0"), cell)))
        for place, blur in enumerate(BLURS):
            whole = blocks(linear(made(Rung("surround", f"surround:share=1,blur={blur}"), cell)))
            for number, share in enumerate(SHARES):  # it is linear in the share
                off[number, place] += np.abs(encoded(none + share * (whole - none)) - exact).mean()
    best = np.unravel_index(np.argmin(off), off.shape)
    return SHARES[best[0]], BLURS[best[1]]


def dimmed(found: dict[Cell, Scattered], beyond: str) -> float:
    """By how much the airlight's levels are lowered for the smallest mean error on the fitted frames."""
    fitted = [cell for cell in found if cell.is_core and cell.surround == beyond and is_fitted(cell.frame)]

    def error(share: float) -> float:
        rung = Rung("homogeneous", "homogeneous", dimmed=share)
        return float(np.mean([np.abs(difference(rung, cell, found[cell])).mean() for cell in fitted]))

    return min(DIMMED, key=error)


def shares(cells: Sequence[Cell]) -> dict[Cell, float]:
    """Share of a frame's light that fog takes, as `auto` computes it."""
    return {cell: ladder.lost(scene(cell.frame).depth, along(scene(cell.frame)), cell.beta) for cell in cells}


def bounds(errors: pd.DataFrame, found: dict[Cell, Scattered]) -> pd.DataFrame:
    """Factors of `fog.ladder`: of each surround, model and beta the largest error per share on the fitted frames."""
    lost, lines = shares([cell for cell in found if cell.is_core]), []
    for beyond, model, beta in product((OPEN, GROUND), ladder.RUNGS, BETAS):
        ratios = [
            _mean(errors, cell, model) / lost[cell]
            for cell in lost
            if (cell.surround, cell.beta) == (beyond, beta) and is_fitted(cell.frame)
        ]
        lines.append((beyond, model, beta, round(max(ratios), 2)))
    return pd.DataFrame(lines, columns=list(ladder.COLUMNS))


def held(errors: pd.DataFrame, found: dict[Cell, Scattered], factors: pd.DataFrame) -> pd.DataFrame:
    """On the frames that were not fitted: bound and error of each rung, in levels."""
    known = _factors(factors)
    lost, lines = shares([cell for cell in found if cell.is_core and not is_fitted(cell.frame)]), []
    for cell, model in product(lost, ladder.RUNGS):
        bound = ladder.bound(model, cell.surround, cell.beta, lost[cell], known)
        lines.append((cell.frame, cell.surround, cell.beta, model, bound, _mean(errors, cell, model)))
    return pd.DataFrame(lines, columns=["frame", "surround", "beta", "model", "bound", "error"])


def enough(scored: pd.DataFrame, tolerances: Sequence[float], costs: dict[str, float]) -> pd.DataFrame:
    """How often each rung is the cheapest within a tolerance, on frames that were not fitted, and what that saves.

    costs : CPU ms of each rung per image; saved : against taking the last rung always
    """
    lines = []
    frames = scored.pivot_table(index=["surround", "beta", "frame"], columns="model", values=["bound", "error"])
    for tolerance in tolerances:
        taken, missed, real = [], 0, []
        for _, line in frames.iterrows():
            fitting = [model for model in ladder.RUNGS if line["bound"][model] <= tolerance]
            missed += not fitting
            taken.append(fitting[0] if fitting else min(ladder.RUNGS, key=lambda model: line["bound"][model]))
            real.append(line["error"][taken[-1]])
        spent = float(np.mean([costs[model] for model in taken]))
        counts = {model: sum(one == model for one in taken) for model in ladder.RUNGS}
        over = sum(error > tolerance for error in real)
        lines.append(
            (tolerance, *counts.values(), missed, over, float(np.mean(real)), 1 - spent / costs[ladder.RUNGS[-1]])
        )
    named = ["tolerance", *ladder.RUNGS, "no model is enough", "over the tolerance", "mean error", "CPU time saved"]
    return pd.DataFrame(lines, columns=named)


def _mean(errors: pd.DataFrame, cell: Cell, model: str) -> float:
    core = {"frame": cell.frame, "beta": cell.beta, "surround": cell.surround, "albedo": cell.albedo}
    core |= {"asymmetry": cell.asymmetry, "height": cell.height, "model": model, "airlight": "estimated"}
    here = errors[np.logical_and.reduce([errors[key] == value for key, value in core.items()])]
    return float(here["mean"].iloc[0])


def _factors(table: pd.DataFrame) -> ladder.Factors:
    return {
        (str(key[0]), str(key[1])): (tuple(part["beta"].sort_values()), tuple(part.sort_values("beta")["factor"]))
        for key, part in table.groupby(["surround", "model"])
    }
