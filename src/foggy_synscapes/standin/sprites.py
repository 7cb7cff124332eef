"""Flat figures: people, riders, poles, lights, signs and trees, drawn once as maps of part numbers.

A sprite is looked up by nearest neighbour at any scale; colours, labels and instances come in by part,
so that one figure serves every coat and a rider and a bicycle stay two instances.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from foggy_synscapes.standin.noise import NOISE

PIXELS_PER_METRE = 80

# parts of people and riders
SKIN, HAIR, COAT, TROUSERS, SHOES, BAG, WHEEL, HUB, BODY, METAL, LAMP = range(1, 12)
PARTS = 12
# parts of street furniture
POST, PLATE, RIM, SYMBOL, CASE, RED, AMBER, GREEN = range(1, 9)
# parts of plants
TRUNK, LEAF, LEAF_LIT, LEAF_DARK = range(1, 5)


@dataclass(frozen=True)
class Sprite:
    """Part numbers uint8 (h, w), 0 transparent; shade float32 (h, w); width and height in metres."""

    parts: np.ndarray
    shade: np.ndarray
    width: float
    height: float


class Sketch:
    """A drawing board in metres, x from the middle, y up from the foot."""

    def __init__(self, width: float, height: float, resolution: int = PIXELS_PER_METRE) -> None:
        self.width, self.height = width, height
        rows, columns = round(height * resolution), round(width * resolution)
        self.parts = np.zeros((rows, columns), np.uint8)
        self.x = ((np.arange(columns) + 0.5) / columns - 0.5)[None, :] * width
        self.y = (1 - (np.arange(rows) + 0.5) / rows)[:, None] * height

    def disc(self, x: float, y: float, radius: float, part: int, flat: float = 1.0) -> None:
        """A filled ellipse, `flat` times as high as wide."""
        self.parts[(self.x - x) ** 2 + ((self.y - y) / flat) ** 2 <= radius**2] = part

    def limb(
        self, x0: float, y0: float, x1: float, y1: float, radius: float, part: int, end: float | None = None
    ) -> None:
        """A rounded stroke from one point to another, its radius changing to `end`."""
        length = (x1 - x0) ** 2 + (y1 - y0) ** 2
        along = np.clip(((self.x - x0) * (x1 - x0) + (self.y - y0) * (y1 - y0)) / max(length, 1e-9), 0, 1)
        width = radius if end is None else radius + (end - radius) * along
        away = (self.x - x0 - along * (x1 - x0)) ** 2 + (self.y - y0 - along * (y1 - y0)) ** 2
        self.parts[away <= width**2] = part

    def box(self, x0: float, y0: float, x1: float, y1: float, part: int) -> None:
        """A filled rectangle."""
        self.parts[(self.x >= x0) & (self.x <= x1) & (self.y >= y0) & (self.y <= y1)] = part

    def triangle(self, x: float, y: float, side: float, part: int, up: bool = True) -> None:
        """A filled triangle around its middle."""
        v = (self.y - y) * (1 if up else -1)
        self.parts[(v >= -0.35 * side) & (np.abs(self.x - x) <= (0.5 * side - v) * 0.58)] = part

    def finish(self, shade: np.ndarray | None = None) -> Sprite:
        """The sprite, shaded from left to right unless told otherwise."""
        if shade is None:
            tone = 1.0 + 0.16 * np.clip(self.x / (self.width / 2), -1, 1) + 0.0 * self.y
            shade = tone * (0.9 + 0.1 * np.clip(self.y / self.height, 0, 1))
        return Sprite(self.parts, np.ascontiguousarray(shade, dtype=np.float32), self.width, self.height)


@cache
def person(pose: int) -> Sprite:
    """A standing or walking person of 1.75 m; poses 0 to 3."""
    s = Sketch(0.95, 1.85)
    stride = (0.03, 0.2, 0.28, 0.1)[pose]
    swing = (0.05, 0.16, 0.22, 0.3)[pose]
    s.limb(-0.06, 0.9, -0.09 - stride, 0.07, 0.1, TROUSERS, 0.06)
    s.limb(0.06, 0.9, 0.09 + stride, 0.07, 0.1, TROUSERS, 0.06)
    s.limb(-0.1 - stride, 0.05, -0.02 - stride, 0.05, 0.05, SHOES)
    s.limb(0.08 + stride, 0.05, 0.18 + stride, 0.05, 0.05, SHOES)
    s.limb(-0.17, 1.38, -0.2 - swing, 0.95, 0.065, COAT)
    s.limb(0.17, 1.38, 0.2 + swing, 0.98, 0.065, COAT)
    s.disc(-0.2 - swing, 0.9, 0.055, SKIN)
    s.disc(0.2 + swing, 0.93, 0.055, SKIN)
    s.limb(0, 1.36, 0, 0.92, 0.21, COAT, 0.17 if pose != 2 else 0.25)
    if pose in (1, 3):
        s.box(-0.33, 0.85, -0.2, 1.2, BAG)
    s.limb(0, 1.48, 0, 1.56, 0.06, SKIN)
    s.disc(0, 1.67, 0.115, HAIR, 1.2)
    s.disc(0.03, 1.63, 0.09, SKIN, 1.2)
    return s.finish()


def _two_wheels(s: Sketch, radius: float, gap: float, tyre: float) -> None:
    for x in (-gap, gap):
        s.disc(x, radius, radius, WHEEL)
        s.disc(x, radius, radius - tyre, HUB)
        s.disc(x, radius, 0.06, METAL)


@cache
def cycle(kind: str, side: bool, ridden: bool) -> Sprite:
    """A bicycle or motorcycle, seen from the side or from behind, with or without its rider."""
    motor = kind == "motorcycle"
    s = Sketch(2.2 if side else 1.0, 1.85)
    if side:
        _two_wheels(s, 0.33, 0.62 if motor else 0.54, 0.13 if motor else 0.06)
        if motor:
            s.limb(-0.62, 0.55, 0.15, 0.6, 0.16, BODY)
            s.disc(0.02, 0.45, 0.2, METAL)
            s.limb(0.1, 0.78, 0.42, 0.74, 0.13, BODY)
            s.limb(0.38, 0.85, 0.62, 0.33, 0.06, METAL)
            s.limb(-0.7, 0.33, 0.0, 0.3, 0.06, METAL)
            s.limb(-0.55, 0.75, 0.05, 0.72, 0.07, HUB)
            s.disc(0.56, 0.85, 0.09, LAMP)
            s.limb(0.36, 1.02, 0.46, 0.85, 0.04, METAL)
        else:
            frame = (
                (-0.54, 0.33, -0.15, 0.85), (-0.54, 0.33, 0.0, 0.3), (0.0, 0.3, -0.15, 0.9),
                (0.0, 0.3, 0.38, 0.85), (-0.12, 0.82, 0.38, 0.85), (0.38, 0.95, 0.54, 0.33),
            )  # fmt: skip
            for tube in frame:
                s.limb(*tube, 0.04, BODY)
            s.limb(-0.3, 0.95, -0.08, 0.95, 0.05, METAL)
            s.limb(0.3, 1.05, 0.44, 1.0, 0.035, METAL)
        if ridden:
            s.limb(-0.15, 0.98, 0.16, 0.66, 0.1, TROUSERS, 0.08)
            s.limb(0.16, 0.66, 0.02, 0.24, 0.075, TROUSERS, 0.06)
            s.limb(0.0, 0.2, 0.14, 0.2, 0.05, SHOES)
            s.limb(-0.16, 1.02, 0.06, 1.4, 0.17, COAT, 0.16)
            s.limb(0.1, 1.36, 0.4, 1.08, 0.06, COAT)
            s.disc(0.42, 1.06, 0.05, SKIN)
            s.disc(0.15, 1.62, 0.11, SKIN, 1.15)
            s.disc(0.13, 1.69, 0.13, HAIR, 0.8 if motor else 0.62)
    else:
        s.limb(0, 0.33 - 0.25, 0, 0.58, 0.1 if motor else 0.055, WHEEL)
        if motor:
            s.limb(0, 0.5, 0, 0.85, 0.2, BODY)
            s.disc(0, 0.72, 0.1, LAMP)
            s.limb(-0.36, 1.02, 0.36, 1.02, 0.045, METAL)
        else:
            s.limb(0, 0.5, 0, 0.9, 0.045, BODY)
            s.limb(-0.28, 1.0, 0.28, 1.0, 0.04, METAL)
        if ridden:
            s.limb(-0.08, 0.95, -0.17, 0.55, 0.1, TROUSERS, 0.08)
            s.limb(0.08, 0.95, 0.17, 0.6, 0.1, TROUSERS, 0.08)
            s.limb(-0.17, 0.55, -0.13, 0.25, 0.07, TROUSERS)
            s.limb(0.17, 0.6, 0.13, 0.32, 0.07, TROUSERS)
            s.disc(-0.13, 0.2, 0.06, SHOES)
            s.disc(0.13, 0.27, 0.06, SHOES)
            s.limb(0, 1.0, 0, 1.36, 0.19, COAT, 0.21)
            s.limb(-0.2, 1.38, -0.3, 1.06, 0.065, COAT)
            s.limb(0.2, 1.38, 0.3, 1.06, 0.065, COAT)
            s.disc(0, 1.62, 0.12, SKIN, 1.15)
            s.disc(0, 1.69, 0.135, HAIR, 0.8)
    return s.finish()


@cache
def traffic_light(lit: int, arm: bool) -> Sprite:
    """A traffic light on its post, with red, amber or green lit (0, 1, 2); with `arm` over the road on a mast."""
    s = Sketch(4.0 if arm else 0.6, 5.9 if arm else 3.6, 40 if arm else PIXELS_PER_METRE)
    if arm:
        s.box(1.6, 0, 1.8, 5.5, POST)
        s.box(-1.7, 5.3, 1.8, 5.48, POST)
    else:
        s.box(-0.09, 0, 0.09, 2.6, POST)
    places = ((-1.5, 4.5), (1.45, 2.5)) if arm else ((0.0, 2.35),)
    for x, y in places:
        s.box(x - 0.24, y, x + 0.24, y + 1.22, CASE)
        for number, part in enumerate((RED, AMBER, GREEN)):
            if number == lit:
                s.disc(x, y + 0.98 - 0.37 * number, 0.16, part)
    return s.finish()


SIGNS = ("limit", "triangle", "yield", "blue", "priority", "stop", "board", "direction")


@cache
def sign(kind: str) -> Sprite:
    """A traffic sign on its post, one of `SIGNS`."""
    s = Sketch(2.4 if kind == "direction" else 1.1, 3.4)
    if kind == "direction":
        s.box(-0.75, 0, -0.65, 3.3, POST)
        s.box(0.65, 0, 0.75, 3.3, POST)
        s.box(-1.15, 2.0, 1.15, 3.35, RIM)
        s.box(-1.08, 2.07, 1.08, 3.28, PLATE)
        for y in (2.35, 2.75, 3.05):
            s.box(-0.8, y, 0.5, y + 0.1, SYMBOL)
        return s.finish()
    s.box(-0.06, 0, 0.06, 3.0, POST)
    y = 2.75
    if kind in ("limit", "blue"):
        s.disc(0, y, 0.48, RIM)
        s.disc(0, y, 0.37, PLATE)
        s.box(-0.17, y - 0.15, -0.04, y + 0.15, SYMBOL)
        s.box(0.04, y - 0.15, 0.17, y + 0.15, SYMBOL)
    elif kind in ("triangle", "yield"):
        s.triangle(0, y, 0.95, RIM, kind == "triangle")
        s.triangle(0, y, 0.62, PLATE, kind == "triangle")
        if kind == "triangle":
            s.box(-0.05, y - 0.15, 0.05, y + 0.12, SYMBOL)
    elif kind == "priority":
        s.parts[np.abs(s.x) + np.abs(s.y - y) <= 0.55] = RIM
        s.parts[np.abs(s.x) + np.abs(s.y - y) <= 0.4] = PLATE
    elif kind == "stop":
        inside = (np.abs(s.x) <= 0.46) & (np.abs(s.y - y) <= 0.46) & (np.abs(s.x) + np.abs(s.y - y) <= 0.65)
        s.parts[inside] = PLATE
        s.box(-0.34, y - 0.09, 0.34, y + 0.09, SYMBOL)
    else:
        s.box(-0.45, y - 0.55, 0.45, y + 0.55, RIM)
        s.box(-0.39, y - 0.49, 0.39, y + 0.49, PLATE)
        s.box(-0.2, y - 0.25, 0.2, y + 0.2, SYMBOL)
    return s.finish()


@cache
def post(kind: str) -> Sprite:
    """A "lamp" of 7 m, a plain "pole" of 5 m or a "bollard" of 1 m."""
    if kind == "lamp":
        s = Sketch(2.4, 7.0, 40)
        s.limb(-1.0, 0.0, -1.0, 6.6, 0.13, POST, 0.08)
        s.limb(-1.0, 6.6, 0.4, 6.85, 0.06, POST)
        s.box(0.3, 6.72, 1.0, 6.9, POST)
    elif kind == "pole":
        s = Sketch(0.4, 5.0)
        s.box(-0.11, 0, 0.11, 5.0, POST)
    else:
        s = Sketch(0.3, 1.0)
        s.box(-0.1, 0, 0.1, 0.95, POST)
        s.box(-0.1, 0.7, 0.1, 0.85, PLATE)
    return s.finish()


@cache
def tree(kind: int) -> Sprite:
    """One of six trees, 8 m high and 6 m wide, or (6, 7) one of two bushes, 2 m high and 3 m wide."""
    rng = np.random.default_rng((8, kind))
    bush = kind >= 6
    s = Sketch(3.0 if bush else 6.0, 2.0 if bush else 8.0, 60 if bush else 32)
    light = np.zeros(s.parts.shape)
    rows, columns = s.parts.shape
    rough = NOISE[(np.arange(rows)[:, None] + 31 * kind) % 256, (np.arange(columns)[None, :] + 77 * kind) % 256]
    if not bush:
        s.limb(0, 0, 0, 5, 0.2, TRUNK, 0.12)
    for _ in range(7 if bush else 11):
        spread = (1.0, 0.9) if bush else (1.9, 5.1)
        x = rng.uniform(-spread[0], spread[0]) * (0.6 if kind in (1, 4) else 1.0)
        y = rng.uniform(0.4, 1.3) if bush else rng.uniform(2.9, 6.9)
        radius = rng.uniform(0.5, 0.8) if bush else rng.uniform(0.8, 1.45) * (1 - 0.3 * abs(x) / 2)
        away = ((s.x - x) ** 2 + (s.y - y) ** 2) / radius**2 + 0.45 * rough
        inside = away <= 0.95
        s.parts[inside] = LEAF
        light[inside] = ((s.y - y) / radius + 0.5 * (s.x - x) / radius + 0.9 * rough)[inside]
    leaves = s.parts == LEAF
    s.parts[leaves & (light > 0.35)] = LEAF_LIT
    s.parts[leaves & (light < -0.25)] = LEAF_DARK
    return s.finish(1.0 + 0.22 * rough)
