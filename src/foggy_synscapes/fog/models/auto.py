"""The cheapest fog model of homogeneous air whose error the atlas bounds by a tolerance, for each frame and beta."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from foggy_synscapes.fog import ladder, models
from foggy_synscapes.fog.geometry import Rays
from foggy_synscapes.fog.models.model import Choice, FogModel
from foggy_synscapes.fog.models.settings import Settings, value
from foggy_synscapes.fog.optics import count_zero_depth, transmittance_images


@dataclass(frozen=True)
class Auto(Settings):
    """What `auto` is told."""

    tolerance: float = value(
        "mean absolute error of a frame that is tolerated, against path tracing", 10.0, "levels", gt=0, le=255
    )
    surround: str = value(
        "what lies outside of the frame: open: the airlight from all sides; ground: road below the horizon",
        "open",
        choices=("open", "ground"),
    )


def _model(values: Auto) -> FogModel:
    def choose(image: np.ndarray, depth: np.ndarray, rays: Rays, airlight: Sequence[int], beta: float) -> Choice:
        count_zero_depth(depth)
        share, known = ladder.lost(depth, rays, beta), ladder.factors()
        bounds = {name: ladder.bound(name, values.surround, beta, share, known) for name in ladder.RUNGS}
        enough = [name for name in ladder.RUNGS if bounds[name] <= values.tolerance]
        taken = enough[0] if enough else min(ladder.RUNGS, key=lambda name: bounds[name])
        said = f"off by at most {bounds[taken]:.1f} levels"
        asked = f"{values.tolerance:g} are tolerated"
        why = f"{said}, {asked}" if enough else f"no model is enough, {asked}; the best, {said}"
        if taken == ladder.DIMMED:
            light = ladder.dimmed(airlight, values.surround)
            return Choice(models.spelling("homogeneous", {"airlight": light}), why)
        own = {"surround": values.surround} if taken == "surround" else {}
        return Choice(models.spelling(taken, own), why)

    def images(
        image: np.ndarray, depth: np.ndarray, rays: Rays, airlight: Sequence[int], betas: Sequence[float]
    ) -> np.ndarray:
        found = [models.chosen(choose(image, depth, rays, airlight, beta).model) for beta in betas]
        each = [one.images(image, depth, rays, airlight, [beta])[0] for one, beta in zip(found, betas, strict=True)]
        return np.stack(each) if each else np.empty((0, *image.shape), np.uint8)

    return FogModel(
        "the cheapest of none, homogeneous (also with a dimmed airlight) and surround whose error is tolerated, "
        "for each frame and beta (values: tolerance, in levels, and surround); each image has a note of it",
        images,
        transmittance_images,
        settings=Auto,
        configure=_model,
        choose=choose,
    )


FOG_MODEL = _model(Auto())
