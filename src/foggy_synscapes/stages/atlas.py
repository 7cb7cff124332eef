"""atlas: how far each fog model is from path tracing, in levels; and the reference itself, rendered anew."""

import argparse
import time
from collections.abc import Callable

import numpy as np
import pandas as pd

from foggy_synscapes.atlas import errors, fit, page, store
from foggy_synscapes.atlas.cells import GROUND, OPEN, SKY, Cell, cells
from foggy_synscapes.atlas.errors import SERIES, SURROUND, Rung
from foggy_synscapes.camera import Camera
from foggy_synscapes.fog import ladder, models
from foggy_synscapes.fog.geometry import rays
from foggy_synscapes.io.progress import progress
from foggy_synscapes.params import Params, load
from foggy_synscapes.provenance.runs import Run
from foggy_synscapes.steps import job

HELP = "Score the fog models against path tracing, in grey levels: which one is enough for which fog."
TIMED = 720, 1440
"""Rows and columns of the frame that is timed, those of Synscapes."""
LINEAR = "surround:share=0"
LADDER = ("none", "homogeneous", "layered", "heterogeneous", "surround")


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this step."""
    parser.add_argument(
        "--render",
        action="store_true",
        help="make the stored reference anew, by Mitsuba 3 (extra `reference`; some CPU minutes), instead of scoring",
    )
    parser.add_argument("--threads", type=int, default=1, metavar="N", help="of the rendering (default: 1)")


def run(args: argparse.Namespace) -> None:
    """Run the step from the command line."""
    if args.render:
        render(args.threads)
    else:
        atlas(load(args.params))


def render(threads: int = 1) -> None:
    """Path-trace every cell, and store the means of blocks beside the package's code."""
    wanted = cells()
    store.write({cell: store.render(cell, threads) for cell in progress(wanted, "atlas", unit="cell")})
    print(f"atlas: {len(wanted)} cells rendered; {store.FILE}")


def atlas(params: Params) -> None:
    """Write tables, the figure and the text to results/atlas, from the stored reference.

    Raises FoggyError if that is missing, altered, or of other frames than the stand-in draws.
    """
    from foggy_synscapes.figures.style import render as drawn
    from foggy_synscapes.tables.formats import long_latex, long_markdown

    run, found = Run(job(params, "atlas")), store.read()
    choices = {beyond: fit.surround(found, beyond) for beyond in (OPEN, GROUND)}
    dims = {beyond: fit.dimmed(found, beyond) for beyond in (OPEN, GROUND)}
    scored = pd.concat([_scored(cell, one, dims) for cell, one in progress(list(found.items()), "atlas", unit="cell")])
    factors = fit.bounds(scored, found)
    held = fit.held(scored, found, factors)
    costs = {name: _cpu_ms(name, params.atlas.repeats) for name in LADDER}
    costs[ladder.DIMMED] = costs["homogeneous"]
    enough = fit.enough(held, params.atlas.tolerances, costs)
    chosen = pd.DataFrame(
        [(beyond, *choices[beyond], dims[beyond]) for beyond in choices],
        columns=["surround", "share", "blur", "airlight times"],
    )
    prices = pd.DataFrame([(name, costs[name], costs[name] / costs["homogeneous"]) for name in LADDER])
    prices.columns = pd.Index(["model", "CPU ms", "times homogeneous"])
    within = float((held["error"] <= held["bound"]).mean())
    caption = (
        f"Fog models against path tracing: mean absolute difference in levels of 8 bits, of means over blocks of "
        f"{store.BLOCK} x {store.BLOCK} pixels, on {len({cell.frame for cell in found})} stand-in frames of 256 x 128 "
        f"pixels; standard error of a block {errors.noise(found):.1f} levels."
    )
    heads = {
        "By surround and beta, frames that nothing was fitted on": page.core(scored, False),
        "By surround and beta, all frames": page.core(scored),
        "By distance, open surround": page.by_distance(scored, errors.BINS),
        "One change at a time, beta 0.02": page.changes(scored),
        "Fitted on half of the frames": chosen,
        "CPU time of one image of 1440 x 720 pixels at one beta": prices,
        "How often each model was the cheapest within a tolerance": enough,
    }
    parts = [caption, *(f"## {head}\n{long_markdown(_rounded(part))}" for head, part in heads.items())]
    parts.append(f"On frames that were not fitted on, the bound held in {within:.0%} of {len(held)} cases.")
    figure = page.figure({beyond: shown(dims[beyond]) for beyond in dims}, found)
    run.write(
        csv=scored.to_csv(index=False, lineterminator="\n", float_format="%.3f"),
        tex=long_latex(_rounded(page.core(scored)), caption, "table:atlas"),
        md="\n\n".join(parts) + "\n",
        bounds=factors.to_csv(index=False, lineterminator="\n"),
        held=held.to_csv(index=False, lineterminator="\n", float_format="%.3f"),
        enough=enough.to_csv(index=False, lineterminator="\n", float_format="%.3f"),
        fitted=chosen.to_csv(index=False, lineterminator="\n"),
        **{ending: drawn(figure, ending) for ending in ("png", "pdf")},
    )
    run.finish()
    print(f"atlas: {len(scored)} scores on {len(found)} cells; {run.job.output('md')}")


def _rungs(cell: Cell, dims: dict[str, float]) -> list[Rung]:
    """What is scored at a cell."""
    found = [Rung(name, name) for name in ("none", "homogeneous", "surround")]
    found.append(Rung("homogeneous, in linear light", LINEAR))
    if cell.surround in dims:
        found.append(Rung(ladder.DIMMED, "homogeneous", dimmed=dims[cell.surround]))
    if cell.surround == SKY:
        found += [Rung(name, name, SURROUND) for name in ("homogeneous", "surround")]
    if cell.height:
        found.append(Rung("layered", "layered"))
    else:
        found.append(Rung(SERIES, ""))
    return found


def shown(dim: float) -> list[Rung]:
    """What is drawn: every model at its defaults, the airlight dimmed by this, and the standard one in linear light."""
    found = [Rung(name, name) for name in LADDER]
    found.insert(2, Rung(ladder.DIMMED, "homogeneous", dimmed=dim))
    return [*found, Rung("in linear light", LINEAR)]


def _scored(cell: Cell, one: store.Scattered, dims: dict[str, float]) -> pd.DataFrame:
    return errors.table(_rungs(cell, dims), {cell: one})


def _rounded(table: pd.DataFrame) -> pd.DataFrame:
    """A table as it is printed: levels to one decimal, parameters as they are."""
    kept = {"beta", "albedo", "asymmetry", "height", "share", "blur", "airlight times", "tolerance", "frame"}
    shown = table.copy()
    for name in shown.columns:
        if name not in kept and shown[name].dtype == np.float64:
            shown[name] = shown[name].map(lambda value: "" if np.isnan(value) else f"{value:.1f}")
        elif name in kept and shown[name].dtype == np.float64:
            shown[name] = shown[name].map("{:g}".format)
    if "CPU time saved" in table.columns:
        shown["CPU time saved"] = table["CPU time saved"].map("{:.0%}".format)
    return shown.astype(str)


def _cpu_ms(model: str, repeats: int) -> float:
    """CPU milliseconds of a model on one frame at one beta."""
    height, width = TIMED
    camera = Camera(1590.8, 1592.8, width / 2, height / 2, width, height)
    way, rng = rays(camera), np.random.default_rng(0)
    assert way.down is not None
    depth = np.clip(1.2 / np.maximum(np.abs(way.down + 0.038), 1e-3), 3, 9000).astype(np.float32)
    depth = np.ascontiguousarray(np.repeat(depth[:, None], width, axis=1))
    image = rng.integers(0, 256, (height, width, 3), dtype=np.uint8)
    make: Callable = models.MODELS[model].images
    make(image, depth, way, (251, 255, 249), [0.02])  # compiled now
    spent = []
    for _ in range(repeats):
        begun = time.process_time()
        make(image, depth, way, (251, 255, 249), [0.02])
        spent.append(time.process_time() - begun)
    return 1000 * min(spent)
