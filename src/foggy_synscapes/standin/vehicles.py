"""Cars, trucks, buses and trains as a few convex solids each, heading along +z, their middle at the origin.

Measures in metres are those of common European vehicles.
"""

from dataclasses import dataclass

import numpy as np

from foggy_synscapes.standin.canvas import BACK, FRONT, LEFT, RIGHT, TOP, Hit, Shader, Solid
from foggy_synscapes.standin.style import Style, colour, noise
from foggy_synscapes.standin.textures import GLASS

RUBBER, LIGHT, TAIL = colour("161618"), colour("ececdc"), colour("b21412")
PAINTS = "961618 1c2c60 1a1c20 c6c8cc 787c82 3c4044 d2d0c8 22463a 8c6e3c 386096"


Vehicle = list[tuple[Solid, Shader]]
"""The widest solid first."""


@dataclass(frozen=True)
class Body:
    """What a painted body stands on: lengths in metres, z along the vehicle, y above the ground."""

    paint: np.ndarray
    half: float  # of its width
    axles: tuple[float, ...]  # z of each; none on rails
    radius: float  # of the wheels
    clearance: float  # y below which it is open between the wheels

    def painted(self, hit: Hit, grain: float, scale: float) -> np.ndarray:
        """Colours of the hits where nothing but paint is, float32 (N, 3)."""
        return self.paint * (1.0 + 0.5 * grain * noise(hit.x + hit.z, hit.y, scale))[:, None].astype(np.float32)

    def add_lamps(self, rgb: np.ndarray, hit: Hit, inset: float, y: float, half: tuple[float, float]) -> None:
        """Lamps at both ends, `inset` from the sides, of this half width and height."""
        lamps = (np.abs(np.abs(hit.x) - self.half + inset) < half[0]) & (np.abs(hit.y - y) < half[1])
        rgb[lamps & (hit.face == FRONT)] = TAIL
        rgb[lamps & (hit.face == BACK)] = LIGHT

    def add_wheels(self, rgb: np.ndarray, hit: Hit, rim: str, inset: float, half: float) -> np.ndarray:
        """Wheels on the sides, and their treads at the ends; returns which hits are solid, bool (N,)."""
        away = np.full(hit.y.shape, np.inf, np.float32)
        for axle in self.axles:
            np.minimum(away, (hit.z - np.float32(axle)) ** 2 + (hit.y - np.float32(self.radius)) ** 2, out=away)
        away[hit.face > RIGHT] = np.inf
        tyre = away < self.radius**2
        rgb[tyre] = RUBBER
        rgb[away < (0.55 * self.radius) ** 2] = colour(rim)
        tread = (hit.face >= FRONT) & (np.abs(np.abs(hit.x) - self.half + inset) < half)
        rgb[tread & (hit.y < self.clearance)] = RUBBER
        return (hit.y >= self.clearance) | tyre | tread


def _glass(mirror: float) -> np.ndarray:
    return GLASS * np.float32(1 - mirror) + np.float32(mirror) * colour("becede")


def _chassis(body: Body, grain: float) -> Shader:
    # The lower body of a car.
    def shade(hit: Hit) -> tuple[np.ndarray, np.ndarray]:
        y, side, end = hit.y, hit.face <= RIGHT, hit.face >= FRONT
        rgb = body.painted(hit, grain, 6.0)
        rgb[(y < body.clearance + 0.14) & (side | end)] = colour("28292b")
        rgb[side & (np.abs(y - 0.82) < 0.03)] *= np.float32(0.7)
        body.add_lamps(rgb, hit, 0.25, 0.68, (0.17, 0.09))
        rgb[end & (np.abs(hit.x) < 0.27) & (np.abs(y - 0.5) < 0.07)] = colour("deded6")
        return rgb, body.add_wheels(rgb, hit, "7e8084", 0.14, 0.12)

    return shade


def _cabin(body: Body, low: float, high: float, middle: float, mirror: float) -> Shader:
    # The upper body of a car: glass between pillars, roof in paint.
    def shade(hit: Hit) -> tuple[np.ndarray, None]:
        rgb = np.repeat(body.paint[None, :], hit.y.size, axis=0)
        level = (hit.y - low) / (high - low)
        side = hit.face <= RIGHT
        pane = (hit.face != TOP) & (level > 0.08) & (level < 0.86)
        pillar = side & (np.abs(hit.z - middle) < 0.05)
        rgb[pane & ~pillar & (side | (np.abs(hit.x) < body.half - 0.12))] = _glass(mirror)
        return rgb, None

    return shade


def _panels(
    body: Body, grain: float, height: float, trim: str, windows: tuple[float, float] | None, bay: float, mirror: float
) -> Shader:
    # One tall body: bus, truck box, or tram with a coloured band. `windows` is the band's lower and upper edge.
    def shade(hit: Hit) -> tuple[np.ndarray, np.ndarray | None]:
        y, side, end = hit.y, hit.face <= RIGHT, hit.face >= FRONT
        rgb = body.painted(hit, grain, 5.0)
        if windows:
            low, high = windows
            rgb[side & (y > low) & (y < high) & (hit.z / bay - np.floor(hit.z / bay) > 0.07)] = _glass(mirror)
            rgb[end & (y > low - 0.25) & (y < high) & (np.abs(hit.x) < body.half - 0.15)] = _glass(mirror)
            if height > high + 0.5:  # room for a destination board: buses and trams, not trucks
                board = end & (y > high + 0.06) & (y < high + 0.3) & (np.abs(hit.x) < 0.7)
                rgb[board] = colour("e69628")
        else:
            rgb[side & ((hit.z / 2.2 - np.floor(hit.z / 2.2)) < 0.03)] *= np.float32(0.75)
            rgb[end & (np.abs(hit.x) < 0.03)] *= np.float32(0.5)
        rgb[(y < body.clearance + 0.25) & (hit.face != TOP)] = colour(trim)
        body.add_lamps(rgb, hit, 0.3, 0.85, (0.18, 0.14))
        rgb[y > height - 0.12] *= np.float32(0.75)
        if body.axles:
            return rgb, body.add_wheels(rgb, hit, "6e7074", 0.25, 0.2)
        rgb[y < body.clearance] = RUBBER
        rgb[(y > 1.0) & (y < 1.22)] = colour("c42828")
        return rgb, None

    return shade


def car(style: Style) -> Vehicle:
    """A hatchback, an estate or a van."""
    rng, paint = style.rng, style.pick(PAINTS)
    form = rng.integers(4)
    end, half = rng.uniform(3.9, 4.8) / 2, rng.uniform(1.72, 1.9) / 2
    belt, roof = (0.95, rng.uniform(1.42, 1.55)) if form < 3 else (1.05, 1.95)
    hood, boot, rake = ((1.35, 0.08, 0.35), (1.2, 0.1, 0.15), (1.3, 0.55, 0.9), (0.75, 0.05, 0.08))[form]
    front, rear, slope, tuck = end - hood, -end + boot, 0.9, 0.28
    side = half - 0.03 + tuck * belt
    windscreens = (BACK, 0, slope, 1, front + slope * belt), (FRONT, 0, rake, -1, -rear + rake * belt)
    flanks = (RIGHT, 1, tuck, 0, side), (LEFT, -1, tuck, 0, side)
    lower = Solid((-half, half), (0.0, belt), (-end, end), ((TOP, 0, 1, 0.25, belt + 0.25 * (end - 0.6)),))
    upper = Solid((-half, half), (belt - 0.02, roof), (rear, front), windscreens + flanks)
    body = Body(paint, half, (-end + 0.78, end - 0.8), 0.33, 0.24)
    cabin = _cabin(body, belt, roof, 0.04 * end, 0.25 + 0.3 * style.weather.glare)
    return [(lower, _chassis(body, style.grain)), (upper, cabin)]


def truck(style: Style) -> Vehicle:
    """A delivery truck: a box behind a cab."""
    paint, grain, mirror = style.pick(PAINTS), style.grain, 0.25 + 0.3 * style.weather.glare
    half, end, height = 1.2, style.rng.uniform(6.5, 8.5) / 2, style.rng.uniform(3.1, 3.6)
    box = style.pick("d6d6d2 bab2a0 465c80 963c30 607656")
    rear = Solid((-half, half), (0, height), (-end, end - 2.0))
    body = Body(box, half, (-end + 1.3, end - 2.6), 0.5, 0.62)
    load = rear, _panels(body, grain, height, "2c2c2e", None, 1.0, mirror)
    half -= 0.06
    front = Solid((-half, half), (0, 2.65), (end - 1.95, end), ((BACK, 0, 0.3, 1, end + 0.3 * 1.5),))
    body = Body(paint, half, (end - 1.0,), 0.5, 0.4)
    cab = front, _panels(body, grain, 2.65, "2c2c2e", (1.45, 2.3), 3.0, mirror)
    return [load, cab]


def bus(style: Style) -> Vehicle:
    """A city bus or a coach."""
    paint = style.pick("b61e24 2454a0 e2dcce d8aa28 34786e")
    half, end, height = 1.25, style.rng.uniform(9.5, 12.0) / 2, style.rng.uniform(3.0, 3.3)
    slants = (BACK, 0, 0.12, 1, end + 0.12 * 1.2), (FRONT, 0, 0.08, -1, end + 0.08 * 1.2)
    body = Body(paint, half, (-end + 2.6, end - 2.4), 0.48, 0.3)
    mirror = 0.2 + 0.3 * style.weather.glare
    shader = _panels(body, style.grain, height, "383a3e", (1.25, 2.45), 1.6, mirror)
    return [(Solid((-half, half), (0, height), (-end, end), slants), shader)]


def train(style: Style) -> Vehicle:
    """A tram: long, sleek-nosed, on rails, with a coloured band below its windows."""
    paint = style.pick("969ca2 c4c6c6 585e68 3c6eb0")
    half, end, height = 1.175, style.rng.uniform(22, 30) / 2, style.rng.uniform(3.4, 3.6)
    slants = (BACK, 0, 0.45, 1, end + 0.45 * 1.1), (FRONT, 0, 0.45, -1, end + 0.45 * 1.1)
    body = Body(paint, half, (), 0.0, 0.2)
    mirror = 0.15 + 0.25 * style.weather.glare
    shader = _panels(body, style.grain, height, "222428", (1.35, 2.7), 2.6, mirror)
    return [(Solid((-half, half), (0, height), (-end, end), slants), shader)]


MAKERS = {"car": car, "truck": truck, "bus": bus, "train": train}
