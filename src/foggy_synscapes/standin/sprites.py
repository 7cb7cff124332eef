"""Flat figures: people, riders, poles, lights, signs and trees, drawn once as maps of part numbers.

A sprite is looked up by nearest neighbour at any scale; colours, labels and instances come in by part,
so that one figure serves every coat and a rider and a bicycle stay two instances.
"""

from collections.abc import Callable
from functools import cache

import numpy as np

from foggy_synscapes.standin.style import ID, NOISE, palette

PIXELS_PER_METRE = 80

# people and bags, cycles, street furniture, plants; 0 is transparent
SKIN, HAIR, COAT, TROUSERS, SHOES, BAG, WHEEL, HUB, BODY, METAL, LAMP = range(1, 12)
POST, BAND, PLATE, RIM, SYMBOL, CASE, RED, AMBER, GREEN, TRUNK, LEAF, LEAF_LIT, LEAF_DARK = range(12, 25)
PARTS = 25

_OF = {"person": 6, "bicycle": 5, "pole": 2, "traffic sign": 3, "traffic light": 4, "vegetation": 4}
LABELS = np.array([0] + [ID[name] for name, parts in _OF.items() for _ in range(parts)])
"""labelId of each part, where nothing else is said."""

_COLOURS = np.zeros((PARTS, 3), np.float32)
_COLOURS[[SHOES, BAG, WHEEL, METAL, BAND]] = palette("282422 5c3c2c 1a1a1c 74767a dcd8c8")
_COLOURS[[CASE, RED, AMBER, GREEN, TRUNK]] = palette("1a1c1c ff3c28 ffbe32 3cf096 4a3c30")


def coloured(parts: dict[int, np.ndarray]) -> np.ndarray:
    """Colours by part, float32 (P, 3): these, and of the parts that always have the same."""
    colours = _COLOURS.copy()
    for part, colour in parts.items():
        colours[part] = colour
    return colours


class Sprite:
    """A drawing board of `width` x `height` metres, x from the middle, y up from the foot.

    parts : uint8 (h, w), 0 transparent; shade : float (h, w), from left to right and up
    """

    def __init__(self, width: float, height: float, resolution: int = PIXELS_PER_METRE) -> None:
        self.width, self.height = width, height
        rows, columns = round(height * resolution), round(width * resolution)
        self.parts = np.zeros((rows, columns), np.uint8)
        self.x = ((np.arange(columns) + 0.5) / columns - 0.5)[None, :] * width
        self.y = (1 - (np.arange(rows) + 0.5) / rows)[:, None] * height
        tone = 1.0 + 0.16 * np.clip(self.x / (width / 2), -1, 1)
        self.shade = (tone * (0.9 + 0.1 * np.clip(self.y / height, 0, 1))).astype(np.float32)

    def draw(self, part: int, *shapes: tuple[float, ...], flat: float = 1.0) -> None:
        """Discs (x, y, radius), `flat` times as high as wide, and strokes with round ends.

        A stroke is (x0, y0, x1, y1, radius), perhaps with another radius at its end.
        """
        for x0, y0, *rest in shapes:
            x1, y1, radius, *end = rest if len(rest) > 1 else (x0, y0, *rest)
            x, y, dx, dy = self.x - x0, (self.y - y0) / flat, x1 - x0, y1 - y0
            along = np.clip((x * dx + y * dy) / max(dx**2 + dy**2, 1e-9), 0, 1)
            width = radius + (end[0] - radius) * along if end else radius
            self.parts[(x - along * dx) ** 2 + (y - along * dy) ** 2 <= width**2] = part

    def box(self, part: int, *corners: tuple[float, float, float, float]) -> None:
        """Filled rectangles (x0, y0, x1, y1)."""
        for x0, y0, x1, y1 in corners:
            self.parts[(self.x >= x0) & (self.x <= x1) & (self.y >= y0) & (self.y <= y1)] = part


@cache
def person(pose: int) -> Sprite:
    """A standing or walking person of 1.75 m; poses 0 to 3."""
    s = Sprite(0.95, 1.85)
    stride, swing = ((0.03, 0.05), (0.2, 0.16), (0.28, 0.22), (0.1, 0.3))[pose]
    s.draw(TROUSERS, *((a * 0.06, 0.9, a * (0.09 + stride), 0.07, 0.1, 0.06) for a in (-1, 1)))
    s.draw(SHOES, (-0.1 - stride, 0.05, -0.02 - stride, 0.05, 0.05), (0.08 + stride, 0.05, 0.18 + stride, 0.05, 0.05))
    s.draw(COAT, (-0.17, 1.38, -0.2 - swing, 0.95, 0.065), (0.17, 1.38, 0.2 + swing, 0.98, 0.065))
    s.draw(SKIN, (-0.2 - swing, 0.9, 0.055), (0.2 + swing, 0.93, 0.055))
    s.draw(COAT, (0, 1.36, 0, 0.92, 0.21, 0.17 if pose != 2 else 0.25))
    if pose in (1, 3):
        s.box(BAG, (-0.33, 0.85, -0.2, 1.2))
    s.draw(SKIN, (0, 1.48, 0, 1.56, 0.06))
    s.draw(HAIR, (0, 1.67, 0.115), flat=1.2)
    s.draw(SKIN, (0.03, 1.63, 0.09), flat=1.2)
    return s


@cache
def cycle(kind: str, side: bool, ridden: bool) -> Sprite:
    """A bicycle or motorcycle, seen from the side or from behind, with or without its rider."""
    s = Sprite(2.2 if side else 1.0, 1.85)
    motor = kind == "motorcycle"
    if side:
        axle, hub = (0.62, 0.2) if motor else (0.54, 0.27)
        for part, radius in ((WHEEL, 0.33), (HUB, hub), (METAL, 0.06)):
            s.draw(part, (-axle, 0.33, radius), (axle, 0.33, radius))
    else:
        s.draw(WHEEL, (0, 0.08, 0, 0.58, 0.1 if motor else 0.055))
    if side and motor:
        s.draw(BODY, (-0.62, 0.55, 0.15, 0.6, 0.16), (0.1, 0.78, 0.42, 0.74, 0.13))
        s.draw(METAL, (0.02, 0.45, 0.2), (0.38, 0.85, 0.62, 0.33, 0.06), (-0.7, 0.33, 0, 0.3, 0.06))
        s.draw(HUB, (-0.55, 0.75, 0.05, 0.72, 0.07))
        s.draw(LAMP, (0.56, 0.85, 0.09))
        s.draw(METAL, (0.36, 1.02, 0.46, 0.85, 0.04))
    elif side:
        s.draw(BODY, (-0.54, 0.33, -0.15, 0.85, 0.04), (-0.54, 0.33, 0, 0.3, 0.04), (0, 0.3, -0.15, 0.9, 0.04))
        s.draw(BODY, (0, 0.3, 0.38, 0.85, 0.04), (-0.12, 0.82, 0.38, 0.85, 0.04), (0.38, 0.95, 0.54, 0.33, 0.04))
        s.draw(METAL, (-0.3, 0.95, -0.08, 0.95, 0.05), (0.3, 1.05, 0.44, 1.0, 0.035))
    elif motor:
        s.draw(BODY, (0, 0.5, 0, 0.85, 0.2))
        s.draw(LAMP, (0, 0.72, 0.1))
        s.draw(METAL, (-0.36, 1.02, 0.36, 1.02, 0.045))
    else:
        s.draw(BODY, (0, 0.5, 0, 0.9, 0.045))
        s.draw(METAL, (-0.28, 1.0, 0.28, 1.0, 0.04))
    if ridden and side:
        s.draw(TROUSERS, (-0.15, 0.98, 0.16, 0.66, 0.1, 0.08), (0.16, 0.66, 0.02, 0.24, 0.075, 0.06))
        s.draw(SHOES, (0, 0.2, 0.14, 0.2, 0.05))
        s.draw(COAT, (-0.16, 1.02, 0.06, 1.4, 0.17, 0.16), (0.1, 1.36, 0.4, 1.08, 0.06))
        s.draw(SKIN, (0.42, 1.06, 0.05))
        s.draw(SKIN, (0.15, 1.62, 0.11), flat=1.15)
        s.draw(HAIR, (0.13, 1.69, 0.13), flat=0.8 if motor else 0.62)
    elif ridden:
        s.draw(TROUSERS, (-0.08, 0.95, -0.17, 0.55, 0.1, 0.08), (0.08, 0.95, 0.17, 0.6, 0.1, 0.08))
        s.draw(TROUSERS, (-0.17, 0.55, -0.13, 0.25, 0.07), (0.17, 0.6, 0.13, 0.32, 0.07))
        s.draw(SHOES, (-0.13, 0.2, 0.06), (0.13, 0.27, 0.06))
        s.draw(COAT, (0, 1.0, 0, 1.36, 0.19, 0.21), (-0.2, 1.38, -0.3, 1.06, 0.065), (0.2, 1.38, 0.3, 1.06, 0.065))
        s.draw(SKIN, (0, 1.62, 0.12), flat=1.15)
        s.draw(HAIR, (0, 1.69, 0.135), flat=0.8)
    return s


@cache
def traffic_light(lit: int, arm: bool) -> Sprite:
    """A traffic light on its post, with red, amber or green lit (0, 1, 2); with `arm` over the road on a mast."""
    s = Sprite(4.0 if arm else 0.6, 5.9 if arm else 3.6, 40 if arm else PIXELS_PER_METRE)
    if arm:
        s.box(POST, (1.6, 0, 1.8, 5.5), (-1.7, 5.3, 1.8, 5.48))
    else:
        s.box(POST, (-0.09, 0, 0.09, 2.6))
    for x, y in ((-1.5, 4.5), (1.45, 2.5)) if arm else ((0.0, 2.35),):
        s.box(CASE, (x - 0.24, y, x + 0.24, y + 1.22))
        s.draw((RED, AMBER, GREEN)[lit], (x, y + 0.98 - 0.37 * lit, 0.16))
    return s


_OUTLINES: dict[str, Callable[[np.ndarray, np.ndarray, float], np.ndarray]] = {
    "disc": lambda x, y, size: x**2 + y**2 <= size**2,
    "triangle": lambda x, y, size: (y >= -0.35 * size) & (x <= (0.5 * size - y) * 0.58),
    "yield": lambda x, y, size: (-y >= -0.35 * size) & (x <= (0.5 * size + y) * 0.58),
    "diamond": lambda x, y, size: x + np.abs(y) <= size,
    "octagon": lambda x, y, size: (x <= size) & (np.abs(y) <= size) & (x + np.abs(y) <= 0.65),
    "upright": lambda x, y, size: (x <= size) & (np.abs(y) <= size + 0.1),
    "wide": lambda x, y, size: (x <= size) & (y >= 0.4 - size) & (y <= size - 0.55),
}
_BARS = ((-0.17, -0.15, -0.04, 0.15), (0.04, -0.15, 0.17, 0.15))
_LINES = ((-0.8, -0.4, 0.5, -0.3), (-0.8, 0, 0.5, 0.1), (-0.8, 0.3, 0.5, 0.4))
SIGNS: dict[str, tuple[str, str, float, float, tuple[tuple[float, float, float, float], ...]]] = {
    "limit": ("c4181c f0f0ec 181818", "disc", 0.48, 0.37, _BARS),
    "triangle": ("c4181c f0f0ec 181818", "triangle", 0.95, 0.62, ((-0.05, -0.15, 0.05, 0.12),)),
    "yield": ("c4181c f0f0ec f0f0ec", "yield", 0.95, 0.62, ()),
    "blue": ("1c50aa 1c50aa f0f0f0", "disc", 0.48, 0.37, _BARS),
    "priority": ("f0f0ec f0c41e f0c41e", "diamond", 0.55, 0.4, ()),
    "stop": ("c4181c c4181c f0f0ec", "octagon", 0.46, 0.46, ((-0.34, -0.09, 0.34, 0.09),)),
    "board": ("f0f0f0 1c50aa f0f0f0", "upright", 0.45, 0.39, ((-0.2, -0.25, 0.2, 0.2),)),
    "direction": ("f0f0f0 1e4696 ececec", "wide", 1.15, 1.08, _LINES),
}
"""Traffic signs: colours of rim, plate and symbol, outline, sizes of rim and plate, and boxes of the symbol, metres."""


@cache
def sign(kind: str) -> Sprite:
    """A traffic sign on its post, one of `SIGNS`."""
    _, outline, *sizes, symbol = SIGNS[kind]
    s, middle = Sprite(2.4 if outline == "wide" else 1.1, 3.4), 2.75
    if outline == "wide":
        s.box(POST, (-0.75, 0, -0.65, 3.3), (0.65, 0, 0.75, 3.3))
    else:
        s.box(POST, (-0.06, 0, 0.06, 3.0))
    for part, size in zip((RIM, PLATE), sizes, strict=True):
        s.parts[_OUTLINES[outline](np.abs(s.x), s.y - middle, size)] = part
    s.box(SYMBOL, *((x0, middle + y0, x1, middle + y1) for x0, y0, x1, y1 in symbol))
    return s


@cache
def post(kind: str) -> Sprite:
    """A "lamp" of 7 m, a plain "pole" of 5 m or a "bollard" of 1 m."""
    if kind == "lamp":
        s = Sprite(2.4, 7.0, 40)
        s.draw(POST, (-1.0, 0.0, -1.0, 6.6, 0.13, 0.08), (-1.0, 6.6, 0.4, 6.85, 0.06))
        s.box(POST, (0.3, 6.72, 1.0, 6.9))
    elif kind == "pole":
        s = Sprite(0.4, 5.0)
        s.box(POST, (-0.11, 0, 0.11, 5.0))
    else:
        s = Sprite(0.3, 1.0)
        s.box(POST, (-0.1, 0, 0.1, 0.95))
        s.box(BAND, (-0.1, 0.7, 0.1, 0.85))
    return s


@cache
def tree(kind: int) -> Sprite:
    """One of six trees, 8 m high and 6 m wide, or (6, 7) one of two bushes, 2 m high and 3 m wide."""
    rng, bush = np.random.default_rng((8, kind)), kind >= 6
    s = Sprite(3.0, 2.0, 60) if bush else Sprite(6.0, 8.0, 32)
    light = np.zeros(s.parts.shape)
    rows, columns = s.parts.shape
    rough = NOISE[(np.arange(rows)[:, None] + 31 * kind) % 256, (np.arange(columns)[None, :] + 77 * kind) % 256]
    if not bush:
        s.draw(TRUNK, (0, 0, 0, 5, 0.2, 0.12))
    for _ in range(7 if bush else 11):
        x = (rng.uniform(-1.0, 1.0) if bush else rng.uniform(-1.9, 1.9)) * (0.6 if kind in (1, 4) else 1.0)
        y = rng.uniform(0.4, 1.3) if bush else rng.uniform(2.9, 6.9)
        radius = rng.uniform(0.5, 0.8) if bush else rng.uniform(0.8, 1.45) * (1 - 0.3 * abs(x) / 2)
        inside = ((s.x - x) ** 2 + (s.y - y) ** 2) / radius**2 + 0.45 * rough <= 0.95
        s.parts[inside] = LEAF
        light[inside] = ((s.y - y) / radius + 0.5 * (s.x - x) / radius + 0.9 * rough)[inside]
    leaves = s.parts == LEAF
    s.parts[leaves & (light > 0.35)] = LEAF_LIT
    s.parts[leaves & (light < -0.25)] = LEAF_DARK
    s.shade = 1.0 + 0.22 * rough
    return s
