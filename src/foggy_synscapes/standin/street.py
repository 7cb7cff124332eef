"""The street itself: where its lanes, kerbs, crossing and houses lie, and how they are painted."""

from dataclasses import dataclass

import numpy as np

from foggy_synscapes.labels import CLASSES, LABEL_IDS
from foggy_synscapes.standin import textures
from foggy_synscapes.standin.canvas import FARTHEST, Canvas, Shader, Solid
from foggy_synscapes.standin.noise import noise
from foggy_synscapes.standin.sky import Weather
from foggy_synscapes.standin.textures import colour

ID = dict(zip(CLASSES, LABEL_IDS, strict=True))
"""labelId by class name."""

STATIC, EGO = 4, 1
"""labelIds of street clutter and of the camera's own car: void in the evaluation."""

FIRST, LAST = 2.0, 0.9 * FARTHEST
"""Metres along the street between which things stand."""


@dataclass(frozen=True)
class Street:
    """A straight street; lateral positions and lengths in metres, the camera's lane centred at 0."""

    lane: float
    left_lanes: tuple[float, ...]  # centres of the oncoming lanes
    right_lanes: tuple[float, ...]  # centres of the camera's lanes
    left_kerb: float
    right_kerb: float
    left_parking: float  # centre of the row of parked cars
    right_parking: float
    parking_presence: float  # share of parking bays in use
    parking_angle: int  # degrees
    median: tuple[float, float] | None
    sidewalks: tuple[float, float]  # widths, left and right
    verges: tuple[float, float]  # widths of the green behind them
    curb_height: float
    crossing: float | None  # distance to a cross street, or none
    crossing_width: float
    rails: float | None  # lateral position of a tram track
    hills: float  # height of the far hills: the altitude variation

    def front(self, side: int) -> float:
        """Lateral position of the house fronts on a side, -1 left or 1 right."""
        if side < 0:
            return self.left_kerb - self.sidewalks[0] - self.verges[0]
        return self.right_kerb + self.sidewalks[1] + self.verges[1]

    def pavement(self, side: int) -> tuple[float, float]:
        """Lateral extent of the sidewalk on a side."""
        if side < 0:
            return self.left_kerb - self.sidewalks[0], self.left_kerb
        return self.right_kerb, self.right_kerb + self.sidewalks[1]

    def stretches(self) -> list[tuple[float, float]]:
        """Where the street is not crossed, along z."""
        if self.crossing is None:
            return [(FIRST, LAST)]
        return [(FIRST, self.crossing), (self.crossing + self.crossing_width, LAST)]

    def crossed(self, z0: float, z1: float) -> bool:
        """Whether [z0, z1] touches the cross street."""
        return self.crossing is not None and z0 < self.crossing + self.crossing_width and z1 > self.crossing


def sample_street(rng: np.random.Generator, trains: bool) -> Street:
    """Draw a street."""
    lane = float(rng.uniform(3.0, 3.5))
    median = float(rng.uniform(1.6, 3.0)) if rng.random() < 0.3 else 0.0
    lefts, rights = 1 + (rng.random() < 0.3), 1 + (rng.random() < 0.2)
    angle = int(rng.choice([0, 0, 0, 45, 90]))
    bay = {0: 2.3, 45: 4.6, 90: 5.0}[angle]
    parked = rng.random(2) < (0.35, 0.5)
    middle = -lane / 2
    left_lanes = tuple(middle - median - lane * (k + 0.5) for k in range(lefts))
    right_lanes = tuple(lane * k for k in range(rights))
    left_edge, right_edge = middle - median - lane * lefts, lane * (rights - 0.5)
    left_kerb, right_kerb = left_edge - bay * bool(parked[0]), right_edge + bay * bool(parked[1])
    verges = tuple(float(rng.uniform(1.5, 6.0)) if rng.random() < 0.45 else 0.0 for _ in range(2))
    return Street(
        lane=lane,
        left_lanes=left_lanes,
        right_lanes=right_lanes,
        left_kerb=left_kerb,
        right_kerb=right_kerb,
        left_parking=(left_edge + left_kerb) / 2 if parked[0] else 0.0,
        right_parking=(right_edge + right_kerb) / 2 if parked[1] else 0.0,
        parking_presence=round(float(rng.uniform(0.4, 1.0)), 4) if parked.any() else 0.0,
        parking_angle=angle if parked.any() else 0,
        median=(middle - median, middle) if median else None,
        sidewalks=(float(rng.uniform(1.8, 4.2)), float(rng.uniform(1.8, 4.2))),
        verges=(verges[0], verges[1]),
        curb_height=round(float(rng.uniform(0.08, 0.18)), 4),
        crossing=float(rng.uniform(14, 60)) if rng.random() < 0.45 else None,
        crossing_width=float(rng.uniform(7, 11)),
        rails=left_lanes[0] if trains and rng.random() < 0.33 else None,
        hills=round(float(rng.uniform(4, 26)), 3),
    )


def paint_ground(canvas: Canvas, street: Street, rng: np.random.Generator, grain: float) -> None:
    """Carriageway with markings, kerbed sidewalks, median, verges and far hills."""
    dx, dy, dz = (ray.ravel() for ray in canvas.rays)
    low = np.flatnonzero(dy < -np.float32(canvas.rig.z / FARTHEST))
    depth = np.float32(canvas.rig.z) / -dy[low]
    x, z = depth * dx[low], depth * dz[low]
    inside = z < LAST
    low, depth, x, z = low[inside], depth[inside], x[inside], z[inside]
    asphalt = colour(*((86, 86, 88), (98, 97, 95), (76, 78, 82), (106, 104, 104))[rng.integers(4)])
    fade = np.minimum(1.0, 9.0 / depth)
    pattern = 1 + (0.04 + 0.8 * grain) * noise(x, z, 10.0) * fade + (0.05 + 0.4 * grain) * noise(x * 6, z, 2.0) * fade
    tracks = np.abs(np.abs(x - np.round(x / street.lane) * street.lane) - 0.8) < 0.3
    pattern -= 0.05 * tracks
    rgb = asphalt[None, :] * (pattern * canvas.light((0, 1, 0)))[:, None].astype(np.float32)
    _markings(street, rgb, x, z, canvas.light((0, 1, 0)), rng)
    crossed = np.zeros(x.shape, bool)
    if street.crossing is not None:
        crossed = (z > street.crossing) & (z < street.crossing + street.crossing_width)
    green = ((x < street.left_kerb) | (x > street.right_kerb)) & ~crossed
    canvas.rgb[low], canvas.depth[low] = rgb, depth
    canvas.label[low] = np.where(green, ID["terrain"], ID["road"])
    lawn = textures.grass(rng, grain)
    if green.any():
        from_above = textures.Hit(
            np.full(int(green.sum()), textures.TOP, np.uint8), x[green], x[green] * 0, z[green], depth[green]
        )
        canvas.rgb[low[green]] = lawn(from_above)[0] * np.float32(canvas.light((0, 1, 0)))
    paving = textures.paving(rng, grain)
    for side in (-1, 1):
        x0, x1 = street.pavement(side)
        for z0, z1 in street.stretches():
            canvas.solid(Solid((x0, 0.0, z0), (x1, street.curb_height, z1)), (0, 0, 0), paving, ID["sidewalk"])
    if street.median:
        for z0, z1 in street.stretches():
            solid = Solid((street.median[0] + 0.2, 0.0, z0), (street.median[1] - 0.2, 0.16, z1))
            canvas.solid(solid, (0, 0, 0), lawn, ID["terrain"])


def _markings(
    street: Street, rgb: np.ndarray, x: np.ndarray, z: np.ndarray, light: float, rng: np.random.Generator
) -> None:
    paint = colour(214, 214, 206) * np.float32(0.92 * light)
    shift = rng.uniform(0, 9)
    dashes = (z + shift) / 9
    dashed = dashes - np.floor(dashes) < 0.42
    width = np.maximum(0.09, z / 700)  # never thinner than a fraction of a pixel
    marks = np.zeros(x.shape, bool)
    for row in (street.left_lanes, street.right_lanes):
        for centre in row[:-1] if len(row) > 1 else ():
            towards = 1 if row is street.right_lanes else -1
            marks |= dashed & (np.abs(x - centre - towards * street.lane / 2) < width)
    if not street.median:
        marks |= (dashed if rng.random() < 0.6 else dashed | True) & (np.abs(x + street.lane / 2) < width)
    for kerb in (street.left_kerb, street.right_kerb):
        marks |= np.abs(x - kerb - (0.3 if kerb < 0 else -0.3)) < 0.8 * width
    if street.crossing is not None:
        start, end = street.crossing, street.crossing + street.crossing_width
        marks &= (z < start - 4.5) | (z > end + 4.5)
        stripes = (x / 1.1 - np.floor(x / 1.1) < 0.5) & (x > street.left_kerb + 0.3) & (x < street.right_kerb - 0.3)
        for z0 in (start - 3.6, end + 0.8):
            marks |= stripes & (z > z0) & (z < z0 + 2.8)
        marks |= (np.abs(z - start + 5.0) < 0.3) & (np.abs(x) < street.lane / 2)
    rgb[marks] = paint
    if street.rails is not None:
        for rail in (street.rails - 0.72, street.rails + 0.72):
            rgb[np.abs(x - rail) < np.maximum(0.08, z / 900)] = colour(58, 54, 52) * np.float32(light)


def paint_houses(
    canvas: Canvas, street: Street, rng: np.random.Generator, weather: Weather, grain: float
) -> dict[str, float]:
    """Rows of houses with gaps, hedges, walls and fences along both sides, and a far skyline.

    Returns the presence (share of the street's length, 0 to 1) and height in metres of walls and fences.
    """
    built = {"wall": 0.0, "fence": 0.0, "wall_height": 0.0, "fence_height": 0.0}
    heights = {"wall": float(rng.uniform(1.4, 2.8)), "fence": float(rng.uniform(1.1, 2.0))}
    green = textures.hedge(rng, grain)
    hill = textures.grass(rng, grain)
    for side in (-1, 1):
        front = street.front(side)
        z = float(rng.uniform(3, 14))
        tall = rng.uniform(5, 12) * (0.6 if weather.blue else 1.0)
        while z < 150:
            length = float(rng.uniform(8, 22))
            kind = rng.random()
            if street.crossing is not None and street.crossed(z - 1, z + length + 1):
                if z < street.crossing - 6 and kind < 0.75:
                    length = street.crossing - 2 - z
                else:
                    z = street.crossing + street.crossing_width + 2
                    continue
            if kind < 0.66:
                _house(
                    canvas,
                    side,
                    front,
                    z,
                    length,
                    float(np.clip(tall + rng.uniform(-3, 3), 3.5, 15)),
                    rng,
                    weather,
                    grain,
                )
            else:
                _plot(canvas, side, front, z, length, heights, built, rng, grain, green)
            z += length + (float(rng.uniform(2, 8)) if rng.random() < 0.22 else 0.0)
        line = front - side * max(0.25, street.verges[0 if side < 0 else 1] - 0.3)
        if street.verges[0 if side < 0 else 1] and rng.random() < 0.75:
            z0 = float(rng.uniform(5, 16))
            z1 = z0 + float(rng.uniform(10, 40))
            if not street.crossed(z0, z1):
                _boundary(
                    canvas,
                    str(rng.choice(["fence", "fence", "fence", "wall", "hedge"])),
                    side,
                    line,
                    z0,
                    z1,
                    heights,
                    built,
                    rng,
                    grain,
                    green,
                )
    for k in range(5):
        x0 = -300 + 120 * k
        top = max(3.0, street.hills * float(rng.uniform(0.5, 1.0))) if k else street.hills
        slope = (0, 1, 0.12, top + 0.12 * LAST)
        canvas.solid(Solid((x0, 0, LAST - 30), (x0 + 120, top, LAST), (slope,)), (0, 0, 0), hill, ID["terrain"])
    for _ in range(4):
        x = float(rng.uniform(-120, 120))
        solid = Solid((x, 0, LAST - 90), (x + float(rng.uniform(20, 50)), float(rng.uniform(5, 16)), LAST - 60))
        if rng.random() < 0.6:
            canvas.solid(solid, (0, 0, 0), green, ID["vegetation"])
        else:
            canvas.solid(solid, (0, 0, 0), textures.facade(rng, solid.high[1], grain, weather.glare), ID["building"])
    return built


def _house(
    canvas: Canvas,
    side: int,
    front: float,
    z: float,
    length: float,
    height: float,
    rng: np.random.Generator,
    weather: Weather,
    grain: float,
) -> None:
    deep = float(rng.uniform(10, 14))
    x0, x1 = (front - deep, front) if side < 0 else (front, front + deep)
    canvas.solid(
        Solid((x0, 0, z), (x1, height, z + length)),
        (0, 0, 0),
        textures.facade(rng, height, grain, weather.glare),
        ID["building"],
    )
    roof = rng.random()
    if roof < 0.65 and z < 90:
        tiles = textures.plain(rng, ((168, 84, 52), (120, 62, 48), (84, 84, 90))[rng.integers(3)], 0.06 + grain)
        eaves = Solid((x0 - 0.3, height, z), (x1 + 0.3, height + 2.6, z + length),
                      ((1, 1.1, 0, x1 + 0.3 + 1.1 * height), (-1, 1.1, 0, -(x0 - 0.3) + 1.1 * height)))  # fmt: skip
        canvas.solid(eaves, (0, 0, 0), tiles, ID["building"])


def _plot(
    canvas: Canvas,
    side: int,
    front: float,
    z: float,
    length: float,
    heights: dict[str, float],
    built: dict[str, float],
    rng: np.random.Generator,
    grain: float,
    green: Shader,
) -> None:
    # An unbuilt plot: closed off by a wall, a fence or a hedge, with bushes behind.
    kind = str(rng.choice(["wall", "fence", "hedge"]))
    _boundary(canvas, kind, side, front, z, z + length, heights, built, rng, grain, green)
    back = front + side * 5.0
    x0, x1 = sorted((back, back + side * 3.0))
    canvas.solid(Solid((x0, 0, z), (x1, float(rng.uniform(2.0, 5.0)), z + length)), (0, 0, 0), green, ID["vegetation"])


def _boundary(
    canvas: Canvas,
    kind: str,
    side: int,
    x: float,
    z0: float,
    z1: float,
    heights: dict[str, float],
    built: dict[str, float],
    rng: np.random.Generator,
    grain: float,
    green: Shader,
) -> None:
    if kind == "hedge":
        height, shader, label = 1.3, green, ID["vegetation"]
    else:
        height, label = heights[kind], ID[kind]
        shader = (textures.masonry if kind == "wall" else textures.palings)(rng, grain)
        built[kind] += (z1 - z0) / 300  # of both sides, 150 m each
        built[f"{kind}_height"] = height
    x0, x1 = sorted((x, x + side * 0.3))
    canvas.solid(Solid((x0, 0, z0), (x1, height, z1)), (0, 0, 0), shader, label)
