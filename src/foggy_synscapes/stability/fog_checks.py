"""Transmittance and fog in each number format, against mpmath."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import mpmath
import numpy as np

from foggy_synscapes.fog.geometry import straight
from foggy_synscapes.fog.optics import foggy_images
from foggy_synscapes.stability.check import Check
from foggy_synscapes.stability.formats import FORMATS, Format

BETAS = np.array([0.0, *np.logspace(-12, 3, 31)])
"""1/m."""
DISTANCES = np.array([0.0, *np.logspace(-2, 38, 41), math.inf])
"""Metres."""
LEVELS = (0, 1, 127, 254, 255)
SMALL = np.logspace(-12, -1, 45)
"""Optical depths at which 1 - t loses what expm1 keeps."""
AREA, HERE = "fog", "as rendered here"


@dataclass(frozen=True)
class Exact:
    """What mpmath gives: transmittance (betas, distances) in its own numbers, and levels by (clear, airlight)."""

    t: np.ndarray
    levels: dict[tuple[int, int], np.ndarray]


def exact(digits: int, distances: np.ndarray) -> Exact:
    """The reference at all BETAS; infinity times a beta of 0 is no fog."""
    with mpmath.workdps(digits):
        t = np.frompyfunc(_transmittance, 2, 1)(BETAS[:, None], distances)
        levels = {(clear, light): exact_levels(t, clear, light) for clear in LEVELS for light in LEVELS}
    return Exact(t, levels)


def exact_levels(t: np.ndarray, clear: int, light: int) -> np.ndarray:
    """Levels of mpmath's transmittances, uint8."""
    half = mpmath.mpf(1) / 2
    return np.frompyfunc(lambda x: int(mpmath.floor(x * clear + (1 - x) * light + half)), 1, 1)(t).astype(np.uint8)


def _transmittance(beta: float, distance: float) -> mpmath.mpf:
    if beta == 0 or distance == 0:
        return mpmath.mpf(1)
    return mpmath.mpf(0) if math.isinf(distance) else mpmath.exp(-mpmath.mpf(beta) * mpmath.mpf(distance))


def checks(digits: int) -> Iterator[Check]:
    """All checks of transmittance and fog."""
    reference = exact(digits, DISTANCES)
    for form in FORMATS:
        yield from _underflow(form)
        yield _overflow(form)
        yield _arithmetic(form, digits)
        yield from _one_minus(form, digits)
        yield _levels(form, reference)
        yield _monotone(
            form.name, lambda x, *colours, form=form: form.levels(form.cast(np.exp(form.cast(-x))), *colours)
        )
        yield from _nothing_and_infinity(form)
    yield _product_levels(digits)
    yield _monotone(HERE, lambda x, *colours: rendered(np.array([1.0]), x, *colours)[0])
    yield from _product_extremes()


def _underflow(form: Format) -> Iterator[Check]:
    """Where t becomes subnormal and where 0: found by bisection, expected from the format's exponents."""
    for name, limit in (("subnormal", form.info.smallest_normal), ("0", form.smallest / 2)):
        expected = -math.log(limit) if limit > 0 else -(math.log(form.smallest) - math.log(2))
        low, high = 0.0, 2000.0
        while high - low > 1e-4 * expected:
            middle = (low + high) / 2
            t = float(form.cast(np.exp(np.float64(-middle))))
            reached = t == 0 if name == "0" else t < form.info.smallest_normal
            low, high = (low, middle) if reached else (middle, high)
        # In 8 bits t is invisible long before: 255 t < 1/2 from 6.23 on.
        good = abs(high - expected) < 1e-2 * expected and expected > 6.24
        yield Check(
            AREA, "t", f"becomes {name} at an optical depth of", form.name, f"{expected:.4g}", f"{high:.4g}", good
        )


def _overflow(form: Format) -> Check:
    """The longest distance of Synscapes' sky has to be a number."""
    found = float(form.cast(8935.0))
    shown = f"{found:g} m; overflows above {form.info.max:.4g} m"
    return Check(AREA, "distance", "overflows", form.name, "finite: 8935 m, the sky dome", shown, math.isfinite(found))


def _arithmetic(form: Format, digits: int) -> Check:
    """Error of t for inputs that the format holds exactly: the product is rounded once, which costs x ulp."""
    betas, distances = (np.unique(form.cast(values).astype(np.float64)) for values in (BETAS, DISTANCES))
    distances = distances[np.isfinite(distances)]
    worst, shown, error = 0.0, 0.0, 0.0
    with mpmath.workdps(digits):
        for beta in betas[np.isfinite(betas)]:
            computed = form.transmittance(distances, beta).astype(np.float64)
            for distance, t in zip(distances, computed, strict=True):
                true = mpmath.exp(-mpmath.mpf(beta) * mpmath.mpf(distance))
                off = abs(float(mpmath.mpf(t) - true))
                error = max(error, off)
                if true >= form.info.smallest_normal:
                    ulps = off / float(form.ulp(np.array(float(true))))
                    shown, worst = max(shown, ulps), max(worst, ulps / (1.5 + beta * distance))
    case, found = "beta 1e-12 to 1e3, distance to 1e38", f"{worst:.2f} of it"
    return Check(AREA, "t", case, form.name, "at most 1.5 + x ulp", found, worst <= 1, shown, error)


def _one_minus(form: Format, digits: int) -> Iterator[Check]:
    """1 - t for thin fog: the plain difference loses it relatively, and keeps it absolutely; expm1 keeps both."""
    x = form.cast(SMALL)
    x = x[x >= form.info.smallest_normal].astype(np.float64)
    with np.errstate(all="ignore"):
        plain = form.cast(form.cast(1.0) - form.cast(np.exp(form.cast(-x))))
        careful = form.cast(-np.expm1(form.cast(-x)))
    for name, values in (("1 - exp(-x)", plain), ("-expm1(-x)", careful)):
        with mpmath.workdps(digits):
            true = [-mpmath.expm1(-mpmath.mpf(value)) for value in x]
        off = np.array([abs(float(mpmath.mpf(float(v)) - t)) for v, t in zip(values, true, strict=True)])
        size, error = np.array([float(t) for t in true]), float(off.max())
        relative, ulps = float((off / size).max()), float((off / form.ulp(size)).max())
        cases = [(f"thin fog, x {x.min():.1g} to 0.1: relative error", relative, 4 * form.unit)]
        if values is plain:
            cases.append(("thin fog: absolute error, which is what 8 bits see", error, 2 * form.unit))
        for case, found, limit in cases:
            asked = f"at most {limit:.1e}"
            yield Check(AREA, name, case, form.name, asked, f"{found:.1e}", found <= limit, ulps, error)


def _levels(form: Format, reference: Exact) -> Check:
    betas, distances = np.meshgrid(BETAS, DISTANCES, indexing="ij")
    defined = ~((betas == 0) & np.isinf(distances))  # judged by itself, see below
    t = form.transmittance(distances, betas)[defined]
    found = {colours: form.levels(t, *colours) for colours in reference.levels}
    return differing(form.name, found, {colours: true[defined] for colours, true in reference.levels.items()})


def differing(form: str, found: dict, true: dict) -> Check:
    """How many levels are other than those of the reference."""
    off = np.abs(np.stack([found[key].astype(int) - true[key] for key in true]))
    wrong, worst = int((off > 0).sum()), int(off.max())
    shown = f"{wrong} of {off.size}" + ("" if form == HERE else f", by up to {worst}")
    case = "levels that differ, inputs over the whole range"
    return Check(AREA, "F", case, form, "0", shown, wrong == 0, None, float(worst))


def _monotone(name: str, levels: Callable[..., np.ndarray]) -> Check:
    """Levels over optical depth never turn back."""
    x, back = np.linspace(0, 7, 14001), 0
    for clear, light in ((0, 255), (255, 0), (40, 251), (250, 251)):
        back += int((np.diff(levels(x, clear, light).astype(int)) * np.sign(light - clear) < 0).sum())
    return Check(AREA, "F", "steps back while fog thickens", name, "0", str(back), back == 0)


def _nothing_and_infinity(form: Format) -> Iterator[Check]:
    """Thin fog over a long way is opaque, and no fog is clear: unless one factor vanishes and the other overflows."""
    for case, distance, beta, expected in (
        ("beta 1e-12, distance 1e38 m", 1e38, 1e-12, 0.0),
        ("beta 0, distance infinite", math.inf, 0.0, 1.0),
    ):
        t = float(form.transmittance(np.array(distance), np.array(beta)))
        yield Check(AREA, "t", case, form.name, f"{expected:g}", f"{t:g}", t == expected)


def rendered(betas: np.ndarray, distances: np.ndarray, clear: int, light: int) -> np.ndarray:
    """Levels as this project renders them, (betas, distances)."""
    image = np.full((1, distances.size, 3), clear, np.uint8)
    depth = distances.astype(np.float32)[None]
    return foggy_images(image, depth, straight(depth.shape), (light,) * 3, betas.tolist())[:, 0, :, 0]


def _product_levels(digits: int) -> Check:
    # Depth arrives in float32: the reference is that of the distances as they are stored.
    with np.errstate(over="ignore"):
        short = DISTANCES.astype(np.float32).astype(np.float64)
    true = exact(digits, short).levels
    return differing(HERE, {colours: rendered(BETAS, short, *colours) for colours in true}, true)


def _product_extremes() -> Iterator[Check]:
    """Answers that the published model implies; clear level 40, airlight 200."""
    cases = (
        ("distance 0, beta 1000", 0.0, 1e3, 40),
        ("distance infinite, beta 1e-12", math.inf, 1e-12, 200),
        ("distance infinite, beta 0", math.inf, 0.0, 40),
        ("distance 8935 m, beta 1e-12", 8935.0, 1e-12, 40),
        ("distance 5.39 m, beta 1000", 5.39, 1e3, 200),
        ("distance 7900 m (sky), beta 0.005", 7900.0, 0.005, 200),
    )
    for case, distance, beta, expected in cases:
        found = int(rendered(np.array([beta]), np.array([distance]), 40, 200)[0, 0])
        yield Check(AREA, "F", case, HERE, str(expected), str(found), found == expected)


def curves(digits: int) -> dict[str, dict[str, tuple[list[float], list[float]]]]:
    """Relative errors over optical depth x = beta l: of t in each format, and of 1 - t in two ways.

    Inputs are what each format holds, so that the error is that of the exponential alone; shown is the largest error of
    ten neighbouring depths.
    """
    depths = np.logspace(-4, np.log10(800), 10 * 80)
    found: dict[str, dict[str, tuple[list[float], list[float]]]] = {"t": {}, "1 - t": {}}
    with mpmath.workdps(digits), np.errstate(all="ignore"):
        for form in FORMATS:
            x = form.cast(depths)
            held = [mpmath.mpf(float(value)) for value in x]
            t, hidden = form.cast(np.exp(-x)), [-mpmath.expm1(-value) for value in held]
            ways = (
                ("t", form.name, t, [mpmath.exp(-value) for value in held]),
                ("1 - t", f"{form.name}, 1 - exp(-x)", form.cast(1 - t), hidden),
                ("1 - t", f"{form.name}, -expm1(-x)", form.cast(-np.expm1(-x)), hidden),
            )
            for panel, name, values, true in ways:
                off = [float(abs(mpmath.mpf(float(v)) / e - 1)) for v, e in zip(values, true, strict=True)]
                found[panel][name] = depths[::10].tolist(), np.array(off).reshape(-1, 10).max(axis=1).tolist()
    return found
