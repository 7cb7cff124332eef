"""Transmittance and fog in each number format, against mpmath."""

import math
from collections.abc import Iterator
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
LEVELS = np.array([0, 1, 127, 254, 255])
SMALL = np.logspace(-12, -1, 45)
"""Optical depths at which 1 - t loses what expm1 keeps."""
AREA = "fog"


@dataclass(frozen=True)
class Exact:
    """What mpmath gives: transmittance (betas, distances) in its own numbers, and levels by (clear, airlight)."""

    t: np.ndarray
    levels: dict[tuple[int, int], np.ndarray]


def exact(digits: int) -> Exact:
    """The reference over the whole grid; infinity times a beta of 0 is no fog."""
    with mpmath.workdps(digits):
        t = np.array([[_transmittance(beta, distance) for distance in DISTANCES] for beta in BETAS], dtype=object)
        half = mpmath.mpf(1) / 2
        levels = {
            (clear, light): np.vectorize(
                lambda x, r=clear, a=light: int(mpmath.floor(x * r + (1 - x) * a + half)), otypes=[np.uint8]
            )(t)
            for clear in LEVELS.tolist()
            for light in LEVELS.tolist()
        }
    return Exact(t, levels)


def _transmittance(beta: float, distance: float) -> mpmath.mpf:
    if beta == 0 or distance == 0:
        return mpmath.mpf(1)
    return mpmath.mpf(0) if math.isinf(distance) else mpmath.exp(-mpmath.mpf(beta) * mpmath.mpf(distance))


def checks(digits: int) -> Iterator[Check]:
    """All checks of transmittance and fog."""
    reference = exact(digits)
    for form in FORMATS:
        yield from _underflow(form)
        yield _overflow(form)
        yield _arithmetic(form, digits)
        yield from _one_minus(form, digits)
        yield _levels(form, reference)
        yield _monotone(form)
        yield from _nothing_and_infinity(form)
    yield _product_levels(reference)
    yield _product_monotone()
    yield from _product_extremes()


def _underflow(form: Format) -> Iterator[Check]:
    """Where t becomes subnormal and where 0: found by bisection, expected from the format's exponents."""
    for name, limit in (("subnormal", form.smallest_normal), ("0", form.smallest / 2)):
        expected = -math.log(limit) if limit > 0 else -(math.log(form.smallest) - math.log(2))
        low, high = 0.0, 2000.0
        while high - low > 1e-4 * expected:
            middle = (low + high) / 2
            t = float(form.cast(np.exp(np.array(-middle)) if form.name != "float64" else np.exp(-np.float64(middle))))
            reached = t == 0 if name == "0" else t < form.smallest_normal
            low, high = (low, middle) if reached else (middle, high)
        good = abs(high - expected) < 1e-2 * expected
        # In 8 bits t is invisible long before: 255 t < 1/2 from 6.23 on.
        case = f"becomes {name} at an optical depth of"
        yield Check(AREA, "t", case, form.name, f"{expected:.4g}", f"{high:.4g}", good and expected > 6.24)


def _overflow(form: Format) -> Check:
    """The longest distance of Synscapes' sky has to be a number."""
    found = float(form.cast(8935.0))
    expected = "finite: 8935 m, the sky dome"
    shown = f"{found:g} m; overflows above {form.largest:.4g} m"
    return Check(AREA, "distance", "overflows", form.name, expected, shown, math.isfinite(found))


def _arithmetic(form: Format, digits: int) -> Check:
    """Error of t for inputs that the format holds exactly: the product is rounded once, which costs x ulp."""
    betas, distances = (np.unique(form.cast(values).astype(np.float64)) for values in (BETAS, DISTANCES))
    worst, shown, error = 0.0, 0.0, 0.0
    with mpmath.workdps(digits):
        for beta in betas[np.isfinite(betas)]:
            finite = distances[np.isfinite(distances)]
            computed = form.transmittance(finite, beta).astype(np.float64)
            for distance, t in zip(finite, computed, strict=True):
                true = mpmath.exp(-mpmath.mpf(beta) * mpmath.mpf(distance))
                off = abs(float(mpmath.mpf(t) - true))
                error = max(error, off)
                if true >= form.smallest_normal:
                    ulps = off / float(form.ulp(np.array(float(true))))
                    shown = max(shown, ulps)
                    worst = max(worst, ulps / (1.5 + beta * distance))
    found = f"{worst:.2f} of it"
    return Check(
        AREA,
        "t",
        "beta 1e-12 to 1e3, distance to 1e38",
        form.name,
        "at most 1.5 + x ulp",
        found,
        worst <= 1,
        shown,
        error,
    )


def _one_minus(form: Format, digits: int) -> Iterator[Check]:
    """1 - t for thin fog: the plain difference loses it relatively, and keeps it absolutely; expm1 keeps both."""
    x = form.cast(SMALL)
    x = x[x >= form.smallest_normal].astype(np.float64)
    with mpmath.workdps(digits):
        true = [-mpmath.expm1(-mpmath.mpf(value)) for value in x]
    with np.errstate(all="ignore"):
        plain = form.cast(form.cast(1.0) - form.cast(np.exp(form.cast(-x))))
        careful = form.cast(-np.expm1(form.cast(-x)))
    for name, values in (("1 - exp(-x)", plain), ("-expm1(-x)", careful)):
        off = np.array([abs(float(mpmath.mpf(float(v)) - t)) for v, t in zip(values, true, strict=True)])
        size = np.array([float(t) for t in true])
        relative, ulps = float((off / size).max()), float((off / form.ulp(size)).max())
        limit = 4 * form.unit
        case = f"thin fog, x {x.min():.1g} to 0.1: relative error"
        yield Check(
            AREA,
            name,
            case,
            form.name,
            f"at most {limit:.1e}",
            f"{relative:.1e}",
            relative <= limit,
            ulps,
            float(off.max()),
        )
        if values is plain:
            fits = float(off.max()) <= 2 * form.unit
            case = "thin fog: absolute error, which is what 8 bits see"
            found = f"{off.max():.1e}"
            yield Check(
                AREA, name, case, form.name, f"at most {2 * form.unit:.1e}", found, fits, ulps, float(off.max())
            )


def _levels(form: Format, reference: Exact) -> Check:
    betas, distances = np.meshgrid(BETAS, DISTANCES, indexing="ij")
    defined = ~((betas == 0) & np.isinf(distances))  # judged by itself, see below
    t = form.transmittance(distances, betas)[defined]
    worst, wrong, count = 0, 0, 0
    for (clear, light), true in reference.levels.items():
        off = np.abs(form.levels(t, np.float64(clear), np.float64(light)).astype(int) - true[defined])
        worst, wrong, count = max(worst, int(off.max())), wrong + int((off > 0).sum()), count + off.size
    found = f"{wrong} of {count}, by up to {worst}"
    case = "levels that differ, inputs over the whole range"
    return Check(AREA, "F", case, form.name, "0", found, wrong == 0, None, float(worst))


def _monotone(form: Format) -> Check:
    x = np.linspace(0, 7, 14001)
    t = form.cast(np.exp(form.cast(-x)))
    back = 0
    for clear, light in ((0, 255), (255, 0), (40, 251), (250, 251)):
        levels = form.levels(t, np.float64(clear), np.float64(light)).astype(int)
        back += int((np.diff(levels) * np.sign(light - clear) < 0).sum())
    return Check(AREA, "F", "steps back while fog thickens", form.name, "0", str(back), back == 0)


def _nothing_and_infinity(form: Format) -> Iterator[Check]:
    """Thin fog over a long way is opaque, and no fog is clear: unless one factor vanishes and the other overflows."""
    for case, distance, beta, expected in (
        ("beta 1e-12, distance 1e38 m", 1e38, 1e-12, 0.0),
        ("beta 0, distance infinite", math.inf, 0.0, 1.0),
    ):
        t = float(form.transmittance(np.array(distance), np.array(beta)))
        yield Check(AREA, "t", case, form.name, f"{expected:g}", f"{t:g}", t == expected)


def _product(betas: np.ndarray, distances: np.ndarray, clear: int, light: int) -> np.ndarray:
    """Levels as this project renders them, (betas, distances)."""
    image = np.full((1, distances.size, 3), clear, np.uint8)
    depth = distances.astype(np.float32)[None]
    return foggy_images(image, depth, straight(depth.shape), (light,) * 3, betas.tolist())[:, 0, :, 0]


def _product_levels(reference: Exact) -> Check:
    with np.errstate(over="ignore"):
        short = DISTANCES.astype(np.float32).astype(np.float64)
    # Depth arrives in float32: the reference is that of the distances as they are stored.
    with mpmath.workdps(50):
        t = np.array([[_transmittance(beta, distance) for distance in short] for beta in BETAS], dtype=object)
        wrong = 0
        for clear, light in reference.levels:
            true = np.array(
                [[int(mpmath.floor(x * clear + (1 - x) * light + mpmath.mpf(0.5))) for x in row] for row in t]
            )
            wrong += int((_product(BETAS, short, clear, light) != true).sum())
    count = len(reference.levels) * t.size
    case = "levels that differ, inputs over the whole range"
    return Check(
        AREA, "F", case, "as rendered here", "0", f"{wrong} of {count}", wrong == 0, None, 0.0 if not wrong else None
    )


def _product_monotone() -> Check:
    x, back = np.linspace(0, 7, 14001), 0
    for clear, light in ((0, 255), (255, 0), (40, 251), (250, 251)):
        levels = _product(np.array([1.0]), x, clear, light)[0].astype(int)
        back += int((np.diff(levels) * np.sign(light - clear) < 0).sum())
    return Check(AREA, "F", "steps back while fog thickens", "as rendered here", "0", str(back), back == 0)


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
        found = int(_product(np.array([beta]), np.array([distance]), 40, 200)[0, 0])
        yield Check(AREA, "F", case, "as rendered here", str(expected), str(found), found == expected)


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
            t = form.cast(np.exp(-x))
            ways = {
                ("t", form.name): (t, [mpmath.exp(-value) for value in held]),
                ("1 - t", f"{form.name}, 1 - exp(-x)"): (form.cast(1 - t), [-mpmath.expm1(-value) for value in held]),
                ("1 - t", f"{form.name}, -expm1(-x)"): (
                    form.cast(-np.expm1(-x)),
                    [-mpmath.expm1(-value) for value in held],
                ),
            }
            for (panel, name), (values, true) in ways.items():
                off = [float(abs(mpmath.mpf(float(v)) / e - 1)) for v, e in zip(values, true, strict=True)]
                found[panel][name] = depths[::10].tolist(), np.array(off).reshape(-1, 10).max(axis=1).tolist()
    return found
