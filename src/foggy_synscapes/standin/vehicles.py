"""Cars, trucks, buses and trains as a few convex solids each, heading along +z, their middle at the origin.

Measures in metres are those of common European vehicles.
"""

from dataclasses import dataclass

import numpy as np

from foggy_synscapes.standin.canvas import Canvas, Hit, Shader, Solid
from foggy_synscapes.standin.noise import noise
from foggy_synscapes.standin.textures import BACK, FRONT, GLASS, LEFT, PAINTS, RIGHT, TOP, colour

RUBBER, LIGHT, TAIL, BUMPER = colour(22, 22, 24), colour(236, 236, 220), colour(178, 20, 18), colour(40, 41, 43)


@dataclass(frozen=True)
class Vehicle:
    """Solids with their shaders, and the whole length and width."""

    pieces: list[tuple[Solid, Shader]]
    length: float
    width: float

    def paint(
        self, canvas: Canvas, position: tuple[float, float, float], heading: float, label: int, instance: int
    ) -> None:
        """Paint every piece at a world position."""
        for solid, shader in self.pieces:
            canvas.solid(solid, position, shader, label, heading, instance)


def _wheels(a: np.ndarray, y: np.ndarray, places: tuple[float, ...], radius: float) -> tuple[np.ndarray, np.ndarray]:
    distance = np.full(a.shape, np.inf, np.float32)
    for place in places:
        np.minimum(distance, (a - np.float32(place)) ** 2 + (y - np.float32(radius)) ** 2, out=distance)
    return distance < radius**2, distance < (0.55 * radius) ** 2


def _chassis(
    paint: np.ndarray, across: float, wheels: tuple[float, ...], radius: float, clearance: float, grain: float,
) -> Shader:  # fmt: skip
    # Lower body: paint, wheels on the sides, lights and bumpers at the ends, open below between the wheels.

    def shade(hit: Hit) -> tuple[np.ndarray, np.ndarray]:
        y, side, end = hit.y, hit.face <= RIGHT, (hit.face == FRONT) | (hit.face == BACK)
        rgb = paint[None, :] * (1.0 + 0.5 * grain * noise(hit.x + hit.z, y, 6.0))[:, None].astype(np.float32)
        rgb[(y < clearance + 0.14) & (side | end)] = BUMPER
        rgb[side & (np.abs(y - 0.82) < 0.03)] *= np.float32(0.7)
        tyre, rim = _wheels(hit.z, y, wheels, radius)
        rgb[side & tyre] = RUBBER
        rgb[side & rim] = colour(126, 128, 132)
        lamps = end & (np.abs(np.abs(hit.x) - across + 0.25) < 0.17) & (np.abs(y - 0.68) < 0.09)
        rgb[lamps & (hit.face == FRONT)] = TAIL
        rgb[lamps & (hit.face == BACK)] = LIGHT
        plate = end & (np.abs(hit.x) < 0.27) & (np.abs(y - 0.5) < 0.07)
        rgb[plate] = colour(222, 222, 214)
        tread = end & (np.abs(np.abs(hit.x) - across + 0.14) < 0.12) & (y < clearance)
        rgb[tread] = RUBBER
        keep = (y >= clearance) | (side & tyre) | tread
        return rgb, keep

    return shade


def _cabin(paint: np.ndarray, low: float, high: float, length: float, width: float, mirror: float) -> Shader:
    # Upper body: glass between pillars, roof in paint.
    def shade(hit: Hit) -> tuple[np.ndarray, None]:
        rgb = np.repeat(paint[None, :], hit.y.size, axis=0)
        glass = GLASS * np.float32(1 - mirror) + np.float32(mirror) * colour(190, 206, 222)
        level = (hit.y - low) / (high - low)
        side = hit.face <= RIGHT
        pane = (hit.face != TOP) & (level > 0.08) & (level < 0.86)
        pillar = side & (np.abs(hit.z - 0.02 * length) < 0.05)
        inner = side | (np.abs(hit.x) < width / 2 - 0.12)
        rgb[pane & ~pillar & inner] = glass
        return rgb, None

    return shade


def _panels(
    paint: np.ndarray, across: float, height: float, windows: tuple[float, float] | None, bay: float, grain: float,
    mirror: float, trim: np.ndarray, wheels: tuple[float, ...] = (), radius: float = 0.48, clearance: float = 0.3,
    rails: bool = False,
) -> Shader:  # fmt: skip
    # One tall body: bus, tram, truck box. `windows` is the band's lower and upper edge.
    def shade(hit: Hit) -> tuple[np.ndarray, np.ndarray]:
        y, side, end = hit.y, hit.face <= RIGHT, (hit.face >= FRONT)
        rgb = paint[None, :] * (1.0 + 0.5 * grain * noise(hit.x + hit.z, y, 5.0))[:, None].astype(np.float32)
        glass = GLASS * np.float32(1 - mirror) + np.float32(mirror) * colour(190, 206, 222)
        if windows:
            u = hit.z / bay - np.floor(hit.z / bay)
            band = (y > windows[0]) & (y < windows[1])
            rgb[side & band & (u > 0.07)] = glass
            rgb[end & (y > windows[0] - 0.25) & (y < windows[1]) & (np.abs(hit.x) < across - 0.15)] = glass
            if height > windows[1] + 0.5:  # room for a destination board: buses and trams, not trucks
                board = end & (y > windows[1] + 0.06) & (y < windows[1] + 0.3) & (np.abs(hit.x) < 0.7)
                rgb[board] = colour(230, 150, 40)
        else:
            rgb[side & ((hit.z / 2.2 - np.floor(hit.z / 2.2)) < 0.03)] *= np.float32(0.75)
            rgb[end & (np.abs(hit.x) < 0.03)] *= np.float32(0.5)
        rgb[(y < clearance + 0.25) & ~(hit.face == TOP)] = trim
        lamps = end & (np.abs(np.abs(hit.x) - across + 0.3) < 0.18) & (np.abs(y - 0.85) < 0.14)
        rgb[lamps & (hit.face != BACK)] = TAIL
        rgb[lamps & (hit.face == BACK)] = LIGHT
        rgb[y > height - 0.12] *= np.float32(0.75)
        keep = y >= clearance
        if wheels:
            tyre, rim = _wheels(hit.z, y, wheels, radius)
            rgb[side & tyre] = RUBBER
            rgb[side & rim] = colour(110, 112, 116)
            tread = end & (np.abs(np.abs(hit.x) - across + 0.25) < 0.2)
            rgb[tread & (y < clearance)] = RUBBER
            keep = keep | (side & tyre) | tread
        if rails:
            rgb[y < clearance] = RUBBER
            keep = np.ones_like(keep)
        return rgb, keep

    return shade


def car(rng: np.random.Generator, grain: float, glare: float) -> Vehicle:
    """A hatchback, an estate or a van."""
    paint = colour(*PAINTS[rng.integers(len(PAINTS))])
    style = rng.integers(4)
    length, width = rng.uniform(3.9, 4.8), rng.uniform(1.72, 1.9)
    belt, roof = (0.95, rng.uniform(1.42, 1.55)) if style < 3 else (1.05, 1.95)
    half, mirror = (width / 2, length / 2), 0.25 + 0.3 * glare
    body = Solid((-half[0], 0.0, -half[1]), (half[0], belt, half[1]), ((0, 1, 0.25, belt + 0.25 * (half[1] - 0.6)),))
    rear = (-half[1] + 0.08, -half[1] + 0.1, -half[1] + 0.55, -half[1] + 0.05)[style]
    front = half[1] - (1.35, 1.2, 1.3, 0.75)[style]
    rake, slope, tuck = (0.35, 0.15, 0.9, 0.08)[style], 0.9, 0.28
    side = half[0] - 0.03 + tuck * belt
    glass = (
        (0, slope, 1, front + slope * belt),
        (0, rake, -1, -rear + rake * belt),
        (1, tuck, 0, side),
        (-1, tuck, 0, side),
    )
    cabin = Solid((-half[0], belt - 0.02, rear), (half[0], roof, front), glass)
    wheels = (-half[1] + 0.78, half[1] - 0.8)
    shaders = _chassis(paint, half[0], wheels, 0.33, 0.24, grain), _cabin(paint, belt, roof, length, width, mirror)
    return Vehicle([(body, shaders[0]), (cabin, _as_faces(shaders[1], (BACK, FRONT, RIGHT, LEFT)))], length, width)


def _as_faces(shader: Shader, cuts: tuple[int, ...]) -> Shader:
    # Slanted cuts are shaded as the faces of the box that they stand for.
    faces = np.array([*range(6), *cuts], np.uint8)

    def shade(hit: Hit) -> tuple[np.ndarray, np.ndarray | None]:
        return shader(Hit(faces[hit.face], hit.x, hit.y, hit.z, hit.depth))

    return shade


def truck(rng: np.random.Generator, grain: float, glare: float) -> Vehicle:
    """A delivery truck: a box behind a cab."""
    paint, length, width, height = (
        colour(*PAINTS[rng.integers(len(PAINTS))]),
        rng.uniform(6.5, 8.5),
        2.4,
        rng.uniform(3.1, 3.6),
    )
    box = colour(*((214, 214, 210), (186, 178, 160), (70, 92, 128), (150, 60, 48), (96, 118, 86))[rng.integers(5)])
    half = length / 2
    rear = Solid((-width / 2, 0, -half), (width / 2, height, half - 2.0))
    cab = Solid((-width / 2 + 0.06, 0, half - 1.95), (width / 2 - 0.06, 2.65, half), ((0, 0.3, 1, half + 0.3 * 1.5),))
    dark, mirror = colour(44, 44, 46), 0.25 + 0.3 * glare
    wheels = (-half + 1.3, half - 2.6)
    return Vehicle(
        [
            (rear, _panels(box, width / 2, height, None, 1, grain, mirror, dark, wheels, 0.5, 0.62)),
            (
                cab,
                _panels(paint, width / 2 - 0.06, 2.65, (1.45, 2.3), 3.0, grain, mirror, dark, (half - 1.0,), 0.5, 0.4),
            ),
        ],
        length,
        width,
    )


def bus(rng: np.random.Generator, grain: float, glare: float) -> Vehicle:
    """A city bus or a coach."""
    paint = colour(*((182, 30, 36), (36, 84, 160), (226, 220, 206), (216, 170, 40), (52, 120, 110))[rng.integers(5)])
    length, width, height = rng.uniform(9.5, 12.0), 2.5, rng.uniform(3.0, 3.3)
    half = length / 2
    body = Solid(
        (-width / 2, 0, -half),
        (width / 2, height, half),
        ((0, 0.12, 1, half + 0.12 * 1.2), (0, 0.08, -1, half + 0.08 * 1.2)),
    )
    shader = _panels(
        paint,
        width / 2,
        height,
        (1.25, 2.45),
        1.6,
        grain,
        0.2 + 0.3 * glare,
        colour(56, 58, 62),
        (-half + 2.6, half - 2.4),
        0.48,
        0.3,
    )
    return Vehicle([(body, _as_faces(shader, (BACK, FRONT)))], length, width)


def train(rng: np.random.Generator, grain: float, glare: float) -> Vehicle:
    """A tram: long, sleek-nosed, on rails, with a coloured band below its windows."""
    paint = colour(*((150, 156, 162), (196, 198, 198), (88, 94, 104), (60, 110, 176))[rng.integers(4)])
    length, width, height = rng.uniform(22, 30), 2.35, rng.uniform(3.4, 3.6)
    half = length / 2
    nose = (0, 0.45, 1, half + 0.45 * 1.1), (0, 0.45, -1, half + 0.45 * 1.1)
    body = Solid((-width / 2, 0, -half), (width / 2, height, half), nose)
    inner = _panels(
        paint,
        width / 2,
        height,
        (1.35, 2.7),
        2.6,
        grain,
        0.15 + 0.25 * glare,
        colour(34, 36, 40),
        (),
        0.4,
        0.2,
        rails=True,
    )

    def shade(hit: Hit) -> tuple[np.ndarray, np.ndarray | None]:
        rgb, keep = inner(hit)
        rgb[(hit.y > 1.0) & (hit.y < 1.22)] = colour(196, 40, 40)
        return rgb, keep

    return Vehicle([(body, _as_faces(shade, (BACK, FRONT)))], length, width)


MAKERS = {"car": car, "truck": truck, "bus": bus, "train": train}
