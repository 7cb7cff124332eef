"""The street itself: where its lanes, kerbs, crossing and houses lie, and how they are painted."""

import math
from dataclasses import dataclass

import numpy as np

from foggy_synscapes.standin import textures
from foggy_synscapes.standin.canvas import FARTHEST, TOP, Canvas, Hit, Solid
from foggy_synscapes.standin.style import ID, colour, noise

FIRST, LAST = 2.0, 0.9 * FARTHEST
"""Metres along the street between which things stand."""


@dataclass(frozen=True)
class Side:
    """One side of a street; lateral positions and widths in metres."""

    sign: int  # -1 left, 1 right
    lanes: tuple[float, ...]  # centres, from the middle of the street outwards
    parking: float | None  # centre of the row of parked cars
    kerb: float
    sidewalk: float  # width
    verge: float  # width of the green behind it, or 0

    @property
    def back(self) -> float:
        """Lateral position of the far edge of the sidewalk."""
        return self.kerb + self.sign * self.sidewalk

    @property
    def front(self) -> float:
        """Lateral position of the house fronts."""
        return self.back + self.sign * self.verge


@dataclass(frozen=True)
class Street:
    """A straight street; lateral positions and lengths in metres, the camera's lane centred at 0."""

    lane: float  # width
    sides: tuple[Side, Side]  # left, oncoming; right, the camera's
    median: tuple[float, float] | None
    parking_presence: float  # share of parking bays in use
    parking_angle: int  # degrees
    curb_height: float
    crossing: tuple[float, float]  # where a cross street begins and ends; inf without one
    rails: float | None  # lateral position of a tram track
    hills: float  # height of the far hills: the altitude variation

    def stretches(self) -> list[tuple[float, float]]:
        """Where the street is not crossed, along z."""
        start, end = self.crossing
        return [(FIRST, start), (end, LAST)] if start < LAST else [(FIRST, LAST)]

    def crossed(self, z0: float, z1: float) -> bool:
        """Whether [z0, z1] touches the cross street."""
        return z0 < self.crossing[1] and z1 > self.crossing[0]


def sample_street(rng: np.random.Generator, trains: bool) -> Street:
    """Draw a street."""
    lane = rng.uniform(3.0, 3.5)
    median = rng.uniform(1.6, 3.0) if rng.random() < 0.3 else 0.0
    counts = 1 + (rng.random() < 0.3), 1 + (rng.random() < 0.2)
    angle = int(rng.choice([0, 0, 0, 45, 90]))
    bay = {0: 2.3, 45: 4.6, 90: 5.0}[angle]
    parked = rng.random(2) < (0.35, 0.5)
    middle = -lane / 2
    oncoming = tuple(middle - median - lane * (k + 0.5) for k in range(counts[0]))
    lanes = oncoming, tuple(lane * k for k in range(counts[1]))
    edges = middle - median - lane * counts[0], lane * (counts[1] - 0.5)
    kerbs = edges[0] - bay * bool(parked[0]), edges[1] + bay * bool(parked[1])
    rows = [(edge + kerb) / 2 if kerb != edge else None for edge, kerb in zip(edges, kerbs, strict=True)]
    verges = [rng.uniform(1.5, 6.0) if rng.random() < 0.45 else 0.0 for _ in range(2)]
    presence = round(rng.uniform(0.4, 1.0), 4) if parked.any() else 0.0
    sidewalks = rng.uniform(1.8, 4.2, 2).tolist()
    left, right = (Side(*side) for side in zip((-1, 1), lanes, rows, kerbs, sidewalks, verges, strict=True))
    curb_height = round(rng.uniform(0.08, 0.18), 4)
    start = rng.uniform(14, 60) if rng.random() < 0.45 else math.inf
    return Street(
        lane=lane,
        sides=(left, right),
        median=(middle - median, middle) if median else None,
        parking_presence=presence,
        parking_angle=angle if parked.any() else 0,
        curb_height=curb_height,
        crossing=(start, start + rng.uniform(7, 11)),
        rails=oncoming[0] if trains and rng.random() < 0.33 else None,
        hills=round(rng.uniform(4, 26), 3),
    )


def paint_ground(canvas: Canvas, street: Street) -> None:
    """Carriageway with markings, kerbed sidewalks, median, verges and far hills."""
    style, grain = canvas.style, canvas.style.grain
    ground = np.flatnonzero(canvas.rays[1] < -np.float32(canvas.rig.z / FARTHEST))
    dx, dy, dz = (ray.take(ground) for ray in canvas.rays)
    depth = np.float32(canvas.rig.z) / -dy
    x, z = depth * dx, depth * dz
    inside = z < LAST
    ground, depth, x, z = (values[inside] for values in (ground, depth, x, z))
    light = style.weather.light(0, 1, 0)
    asphalt = style.pick("565658 62615f 4c4e52 6a6868")
    fade = np.minimum(1.0, 9.0 / depth)
    pattern = 1 + (0.04 + 0.8 * grain) * noise(x, z, 10.0) * fade + (0.05 + 0.4 * grain) * noise(x * 6, z, 2.0) * fade
    pattern -= 0.05 * (np.abs(np.abs(x - np.round(x / street.lane) * street.lane) - 0.8) < 0.3)  # tracks of wheels
    rgb = asphalt * (pattern * light)[:, None].astype(np.float32)
    _paint_markings(street, rgb, x, z, light, style.rng)
    left, right = street.sides
    start, end = street.crossing
    green = ((x < left.kerb) | (x > right.kerb)) & ((z <= start) | (z >= end))
    lawn, paving = textures.grass(style), textures.paving(style)
    from_above = Hit(np.full(green.sum(), TOP), x[green], x[green] * 0, z[green], depth[green])
    rgb[green] = lawn(from_above)[0] * np.float32(light)
    canvas.paint(ground, depth, rgb, np.where(green, ID["terrain"], ID["road"]))
    for side in street.sides:
        for stretch in street.stretches():
            canvas.solid(Solid((side.kerb, side.back), (0.0, street.curb_height), stretch), paving, ID["sidewalk"])
    if street.median:
        width = street.median[0] + 0.2, street.median[1] - 0.2
        for stretch in street.stretches():
            canvas.solid(Solid(width, (0.0, 0.16), stretch), lawn, ID["terrain"])


def _paint_markings(
    street: Street, rgb: np.ndarray, x: np.ndarray, z: np.ndarray, light: float, rng: np.random.Generator
) -> None:
    dashes = (z + rng.uniform(0, 9)) / 9
    dashed = dashes - np.floor(dashes) < 0.42
    width = np.maximum(0.09, z / 700)  # never thinner than a fraction of a pixel
    marks = np.zeros(x.shape, bool)
    for side in street.sides:
        for centre in side.lanes[:-1]:
            marks |= dashed & (np.abs(x - centre - side.sign * street.lane / 2) < width)
    if not street.median:
        marks |= (dashed if rng.random() < 0.6 else True) & (np.abs(x + street.lane / 2) < width)
    for side in street.sides:
        marks |= np.abs(x - side.kerb + side.sign * 0.3) < 0.8 * width
    (start, end), (left, right) = street.crossing, street.sides
    marks &= (z < start - 4.5) | (z > end + 4.5)
    stripes = (x / 1.1 - np.floor(x / 1.1) < 0.5) & (x > left.kerb + 0.3) & (x < right.kerb - 0.3)
    for z0 in (start - 3.6, end + 0.8):
        marks |= stripes & (z > z0) & (z < z0 + 2.8)
    marks |= (np.abs(z - start + 5.0) < 0.3) & (np.abs(x) < street.lane / 2)
    rgb[marks] = colour("d6d6ce") * np.float32(0.92 * light)
    if street.rails is not None:
        for rail in (street.rails - 0.72, street.rails + 0.72):
            rgb[np.abs(x - rail) < np.maximum(0.08, z / 900)] = colour("3a3634") * np.float32(light)


def paint_houses(canvas: Canvas, street: Street) -> dict[str, tuple[float, float]]:
    """Rows of houses with gaps, hedges, walls and fences along both sides, and a far skyline.

    Returns the presence (share of the street's length, 0 to 1) and height in metres of walls and fences.
    """
    style, rng = canvas.style, canvas.style.rng
    heights = {"wall": rng.uniform(1.4, 2.8), "fence": rng.uniform(1.1, 2.0), "hedge": 1.3}
    lengths = dict.fromkeys(heights, 0.0)
    green, hill = textures.hedge(style), textures.grass(style)

    def boundary(kind: str, side: Side, x: float, z0: float, z1: float) -> None:
        shader = {"wall": textures.masonry, "fence": textures.palings}[kind](style) if kind != "hedge" else green
        label = ID["vegetation" if kind == "hedge" else kind]
        lengths[kind] += (z1 - z0) / 300  # of both sides, 150 m each
        canvas.solid(Solid((x, x + side.sign * 0.3), (0, heights[kind]), (z0, z1)), shader, label)

    for side in street.sides:
        front, z = side.front, rng.uniform(3, 14)
        tall = rng.uniform(5, 12) * (0.6 if style.weather.blue else 1.0)
        while z < 150:
            length = rng.uniform(8, 22)
            kind = rng.random()
            if street.crossed(z - 1, z + length + 1):
                if z >= street.crossing[0] - 6 or kind >= 0.75:
                    z = street.crossing[1] + 2
                    continue
                length = street.crossing[0] - 2 - z
            if kind < 0.66:
                _paint_house(canvas, side, z, z + length, min(max(tall + rng.uniform(-3, 3), 3.5), 15.0))
            else:  # an unbuilt plot, closed off, with bushes behind
                boundary(rng.choice(["wall", "fence", "hedge"]), side, front, z, z + length)
                depth = front + side.sign * 5.0, front + side.sign * 5.0 + side.sign * 3.0
                canvas.solid(Solid(depth, (0, rng.uniform(2.0, 5.0)), (z, z + length)), green, ID["vegetation"])
            z += length + (rng.uniform(2, 8) if rng.random() < 0.22 else 0.0)
        if side.verge and rng.random() < 0.75:
            z0 = rng.uniform(5, 16)
            z1 = z0 + rng.uniform(10, 40)
            if not street.crossed(z0, z1):
                kind = rng.choice(["fence", "fence", "fence", "wall", "hedge"])
                boundary(kind, side, front - side.sign * max(0.25, side.verge - 0.3), z0, z1)
    for k in range(5):
        x = -300.0 + 120 * k
        top = max(3.0, street.hills * rng.uniform(0.5, 1.0)) if k else street.hills
        slope = (TOP, 0, 1, 0.12, top + 0.12 * LAST)
        canvas.solid(Solid((x, x + 120), (0, top), (LAST - 30, LAST), (slope,)), hill, ID["terrain"])
    for _ in range(4):
        x = rng.uniform(-120, 120)
        width, height = rng.uniform(20, 50), rng.uniform(5, 16)
        solid = Solid((x, x + width), (0, height), (LAST - 90, LAST - 60))
        if rng.random() < 0.6:
            canvas.solid(solid, green, ID["vegetation"])
        else:
            canvas.solid(solid, textures.facade(style, height), ID["building"])
    return {kind: (min(1.0, length), heights[kind] if length else 0.0) for kind, length in lengths.items()}


def _paint_house(canvas: Canvas, side: Side, z0: float, z1: float, height: float) -> None:
    style, rng = canvas.style, canvas.style.rng
    x0, x1 = sorted((side.front, side.front + side.sign * rng.uniform(10, 14)))
    canvas.solid(Solid((x0, x1), (0, height), (z0, z1)), textures.facade(style, height), ID["building"])
    if rng.random() < 0.65 and z0 < 90:
        tiles = textures.plain(style, "a85434 783e30 54545a", 0.06 + style.grain)
        x0, x1 = x0 - 0.3, x1 + 0.3
        slopes = (TOP, 1, 1.1, 0, x1 + 1.1 * height), (TOP, -1, 1.1, 0, -x0 + 1.1 * height)
        canvas.solid(Solid((x0, x1), (height, height + 2.6), (z0, z1), slopes), tiles, ID["building"])
