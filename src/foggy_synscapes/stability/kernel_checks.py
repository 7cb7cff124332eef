"""The compiled loops as they run: squared transmittances, cameras at their limits, samples next to rounding steps."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import mpmath
import numpy as np

from foggy_synscapes.camera import Camera
from foggy_synscapes.fog.geometry import GEOMETRIES, Rays, rays
from foggy_synscapes.fog.optics import foggy_images
from foggy_synscapes.fog.renderer import exponentials
from foggy_synscapes.stability.check import Check

PAPERS = (0.005, 0.01, 0.02, 0.03, 0.06)
"""1/m; three of them are twice the one before. Source: paper, section III."""
PAIRS = tuple((beta, 2 * beta) for beta in (*PAPERS, *np.logspace(-12, 3, 16).tolist()))
"""Densities of which the second is computed as the square of the first."""
CLOSE = 1e-9
"""Levels from a rounding step: 30,000 times less than one float32 tells apart there."""
ROUNDING = 1e-12
"""Levels by which the published formula in float64 may be off itself."""
TRIES = 16
"""Colours that are tried for each pixel: the one that comes closest to a step is kept."""
WIDE, HIGH = 2048, 1024
"""Pixels of the cameras."""
BOUNDS = {1: 1.4, 2: 2.4, 4: 5.3}
"""Largest errors of 255 t, in units of 2^-15 levels, that `fog.kernel` allows for by the number of factors."""
AREA = "kernel"


def _camera(degrees: float, **moved: float) -> Camera:
    """A camera of a horizontal field of view."""
    focal = WIDE / 2 / math.tan(math.radians(degrees) / 2)
    return replace(Camera(focal, focal, WIDE / 2, HIGH / 2, WIDE, HIGH), **moved)  # type: ignore[arg-type]  # sizes stay


CAMERAS = {
    "field of view 60 degrees": _camera(60),
    "field of view 1 degree": _camera(1),
    "field of view 170 degrees": _camera(170),
    "principal point off the image": _camera(60, u0=-3.0 * WIDE, v0=5.0 * HIGH),
    "fx twice fy": _camera(60, fx=2000.0, fy=1000.0),
}


@dataclass(frozen=True)
class Frame:
    """Pixels with their rays; steps : distance of the sample of the first channel from a rounding step, in levels."""

    image: np.ndarray
    depth: np.ndarray
    rays: Rays
    light: int
    steps: np.ndarray

    def rendered(self, betas: Sequence[float]) -> np.ndarray:
        """Levels of the first channel at each beta, uint8 (B, H, W)."""
        return foggy_images(self.image, self.depth, self.rays, (self.light,) * 3, betas)[..., 0]

    def plain(self, beta: float) -> np.ndarray:
        """The same by the published formula in float64."""
        t = np.exp(-beta * (self.depth * self.rays.factor()))
        return _levels(t, self.image[..., 0], self.light)


def checks(digits: int, searched: int) -> Iterator[Check]:
    """All checks of the compiled loops.

    searched : pixels that are looked through for samples near a step, per camera, geometry and density
    """
    yield from _squares(digits)
    for name, camera in CAMERAS.items():
        for geometry in GEOMETRIES:
            yield from _near_steps(name, camera, geometry, digits, searched)
            yield _extreme_distances(name, camera, geometry)
    yield _pairs()


def _levels(t: np.ndarray, clear: np.ndarray, light: int) -> np.ndarray:
    radiance = t * (clear / 255.0) + (1.0 - t) * (light / 255.0)
    return np.floor(255.0 * radiance + 0.5).astype(np.uint8)


def _squares(digits: int) -> Iterator[Check]:
    """Transmittance before it is composited: float32, some of it squared once or twice."""
    found = dict.fromkeys(BOUNDS, 0.0)
    for betas in (PAPERS, *PAIRS):
        # As far as fog hides what lies behind: elsewhere nothing is computed.
        distance = np.linspace(0, 6.25 / min(betas), 1024).astype(np.float32)
        for beta, factors, t in exponentials(betas, distance):
            visible = np.flatnonzero(beta * distance.astype(float) <= 6.25)
            with mpmath.workdps(digits):
                true = [float(255 * mpmath.exp(-mpmath.mpf(beta) * mpmath.mpf(float(distance[x])))) for x in visible]
            worst = np.abs(255 * t[visible].astype(float) - true).max() * 2**15
            found[factors] = max(found[factors], float(worst))
    for factors, bound in BOUNDS.items():
        case = f"product of {factors}" if factors > 1 else "one exponential"
        texts = f"at most {bound} units of 2^-15 levels", f"{found[factors]:.2f}"
        yield Check(
            AREA, "255 t", case, "as rendered here", *texts, found[factors] <= bound, None, found[factors] / 2**15
        )


def _near_steps(name: str, camera: Camera, geometry: str, digits: int, searched: int) -> Iterator[Check]:
    """Levels next to a step against float64, and those closest to it against mpmath."""
    wrong, count, near, missed, closest, farthest = 0, 0, 0, 0, math.inf, 0.0
    for number, beta in enumerate(PAPERS):
        frame = search(rays(camera, geometry), beta, searched, seed=number)
        rendered = frame.rendered(PAPERS)
        for other, levels in zip(PAPERS, rendered, strict=True):
            wrong, count = wrong + int((levels != frame.plain(other)).sum()), count + levels.size
        closest = min(closest, float(frame.steps.min()))
        for row, column in zip(*np.nonzero(frame.steps < CLOSE), strict=True):
            near += 1
            if int(rendered[number, row, column]) != _exact_level(frame, row, column, beta, digits):
                missed, farthest = missed + 1, max(farthest, float(frame.steps[row, column]))
    case = f"{geometry}, {name}"
    yield Check(AREA, "F against float64", case, "as rendered here", "0", f"{wrong} of {count}", wrong == 0)
    shown = f"{missed} of {near}, the closest {closest:.0e} levels from it"
    case += f": within {CLOSE:g} levels of a step"
    # What float64 cannot tell apart is decided as float64 does: see the check above.
    yield Check(AREA, "F against mpmath", case, "as rendered here", "0", shown, near > 0 and farthest < ROUNDING)


def search(lines: Rays, beta: float, searched: int, seed: int) -> Frame:
    """Pixels all over the image of a camera, with colours and depths whose fog lies next to a rounding step.

    For every pixel some colours and steps are drawn; the depth at which the fog reaches the step is rounded to float32,
    and what comes closest is kept.
    """
    rng = np.random.default_rng(seed)
    width = min(searched, lines.columns.size)
    height = -(-searched // width)
    kept = Rays(lines.rows[rng.integers(lines.rows.size, size=height)], lines.columns[:width], lines.scale)
    factor, light = kept.factor(), int(rng.integers(256))
    steps = np.full((height, width), np.inf)
    clear, depth = np.zeros((height, width), np.uint8), np.zeros((height, width), np.float32)
    for _ in range(TRIES):
        colour = (light + rng.integers(2, 254, steps.shape)) % 256
        share = rng.uniform(0.01, 1, steps.shape)
        step = np.floor(light + share * (colour - light)) + 0.5
        with np.errstate(divide="ignore", invalid="ignore"):
            reached = (-np.log((step - light) / (colour - light)) / beta / factor).astype(np.float32)
        t = np.exp(-beta * (reached * factor))
        off = np.where(np.isfinite(reached) & (reached >= 0), np.abs(light + t * (colour - light) - step), np.inf)
        better = off < steps
        steps[better], clear[better], depth[better] = off[better], colour[better], reached[better]
    image = np.repeat(clear[..., None], 3, axis=2)
    return Frame(image, depth, kept, light, steps)


def _exact_level(frame: Frame, row: int, column: int, beta: float, digits: int) -> int:
    with mpmath.workdps(digits):
        squared = mpmath.mpf(frame.rays.rows[row]) + mpmath.mpf(frame.rays.columns[column])
        distance = mpmath.mpf(float(frame.depth[row, column])) * mpmath.sqrt(squared / mpmath.mpf(frame.rays.scale))
        t, clear = mpmath.exp(-mpmath.mpf(beta) * distance), int(frame.image[row, column, 0])
        return int(mpmath.floor(t * clear + (1 - t) * frame.light + mpmath.mpf(1) / 2))


def _extreme_distances(name: str, camera: Camera, geometry: str) -> Check:
    """At 1e-6 m there is no fog, and at 1e30 m nothing else."""
    lines = rays(camera, geometry).crop(0, 0, 2, WIDE)
    image = np.full((*lines.shape, 3), 40, np.uint8)
    depth = np.repeat(np.array([[1e-6], [1e30]], np.float32), WIDE, axis=1)
    found = foggy_images(image, depth, lines, (200,) * 3, PAPERS)
    shown = "; ".join(str(np.unique(found[:, row]).tolist()).strip("[]") for row in (0, 1))
    case = f"{geometry}, {name}: 1e-6 and 1e30 m"
    return Check(AREA, "F", case, "as rendered here", "40; 200", shown, shown == "40; 200")


def _pairs() -> Check:
    """Two densities at once give what each gives alone: a square of a transmittance decides as its own exponential."""
    lines, wrong, count = rays(CAMERAS["field of view 60 degrees"]).crop(0, 0, 1, WIDE), 0, 0
    rng = np.random.default_rng(0)
    image = rng.integers(0, 256, (*lines.shape, 3), np.uint8)
    for betas in PAIRS:
        depth = (rng.exponential(1.0, lines.shape) / betas[0]).astype(np.float32)
        together = foggy_images(image, depth, lines, (10, 128, 240), betas)
        alone = np.concatenate([foggy_images(image, depth, lines, (10, 128, 240), [beta]) for beta in betas])
        wrong, count = wrong + int((together != alone).sum()), count + alone.size
    case = f"{len(PAIRS)} pairs of beta and 2 beta, together and alone"
    return Check(AREA, "F", case, "as rendered here", "0", f"{wrong} of {count} differ", wrong == 0)
