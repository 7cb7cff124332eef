"""Road users: vehicles in their lanes, parked cars, people on the sidewalks and riders.

Every road user is an instance numbered labelId * 10000 + n, so that all three bytes of the encoding occur.
"""

import math
from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from foggy_synscapes.standin import sprites, vehicles
from foggy_synscapes.standin.canvas import Canvas
from foggy_synscapes.standin.sky import Weather
from foggy_synscapes.standin.street import ID, Street
from foggy_synscapes.standin.textures import PAINTS, colour

STRIDE = 10000

_COATS = (
    (40, 44, 60),
    (150, 40, 44),
    (80, 110, 150),
    (200, 196, 188),
    (60, 80, 60),
    (30, 30, 32),
    (190, 150, 60),
    (120, 70, 110),
)
_TROUSERS = ((34, 38, 54), (50, 70, 110), (26, 26, 28), (120, 108, 88), (90, 92, 96))
_SKINS = ((214, 170, 140), (180, 130, 100), (120, 84, 64), (226, 188, 160))


@dataclass
class Traffic:
    """What was placed: for each instance the kind it counts as in the scene keys, and where it stands (x, z)."""

    kinds: dict[int, str] = field(default_factory=dict)
    places: dict[int, tuple[float, float]] = field(default_factory=dict)
    taken: list[tuple[float, float, float, float]] = field(default_factory=list)
    counts: Counter = field(default_factory=Counter)

    def new(self, name: str, kind: str, place: tuple[float, float]) -> int:
        """Number a new instance of a class."""
        label = ID[name]
        self.counts[label] += 1
        number = label * STRIDE + self.counts[label]
        self.kinds[number], self.places[number] = kind, place
        return number

    def free(self, x: float, z: float, half_x: float, half_z: float) -> bool:
        """Claim a rectangle of ground; False if somebody is there."""
        for other_x, other_z, other_half_x, other_half_z in self.taken:
            if abs(x - other_x) < half_x + other_half_x and abs(z - other_z) < half_z + other_half_z:
                return False
        self.taken.append((x, z, half_x, half_z))
        return True


@dataclass(frozen=True)
class Placed:
    """A vehicle ready to paint."""

    name: str
    vehicle: vehicles.Vehicle
    x: float
    z: float
    heading: float


def place_vehicles(
    street: Street, rng: np.random.Generator, weather: Weather, grain: float, traffic: Traffic
) -> list[Placed]:
    """Draw the vehicles and their places, nobody inside another."""
    placed: list[Placed] = []

    def put(name: str, x: float, z: float, heading: float) -> float:
        vehicle = vehicles.MAKERS[name](rng, grain, weather.glare)
        cos, sin = abs(math.cos(heading)), abs(math.sin(heading))
        half_x = (cos * vehicle.width + sin * vehicle.length) / 2 + 0.2
        half_z = (cos * vehicle.length + sin * vehicle.width) / 2 + 0.4
        centre = z + half_z
        if traffic.free(x, centre, half_x, half_z):
            placed.append(Placed(name, vehicle, x, centre, heading))
        return 2 * half_z

    nearest = 26.0 if weather.blue else 9.0  # tall vehicles leave the blue sky in view
    if street.rails is not None:
        put("train", street.rails, float(rng.uniform(nearest, 34)), math.pi)
    if rng.random() < 0.33:
        lane = float(rng.choice(street.left_lanes + street.right_lanes[-1:]))
        put("bus", lane, float(rng.uniform(nearest, 32)), math.pi if lane in street.left_lanes else 0.0)
    if rng.random() < 0.36:
        lane = float(rng.choice(street.left_lanes + street.right_lanes[-1:]))
        put("truck", lane, float(rng.uniform(nearest, 32)), math.pi if lane in street.left_lanes else 0.0)
    for row, heading in ((street.right_lanes, 0.0), (street.left_lanes, math.pi)):
        for lane in row:
            z = float(rng.uniform(8, 26))
            for _ in range(rng.integers(0, 5)):
                name = str(rng.choice(["car"] * 10 + ["truck", "bus"])) if z > nearest else "car"
                z += put(
                    name, lane + float(rng.uniform(-0.25, 0.25)), z, heading + float(rng.uniform(-0.02, 0.02))
                ) + float(rng.uniform(3, 22))
    turn = math.radians(street.parking_angle)
    step = {0: 5.6, 45: 3.6, 90: 2.7}[street.parking_angle]
    for x, side in ((street.left_parking, -1), (street.right_parking, 1)):
        if not x:
            continue
        for z in np.arange(rng.uniform(6, 10), 60, step).tolist():
            if rng.random() < street.parking_presence and not street.crossed(z - 6, z + 6):
                name = "truck" if rng.random() < 0.03 and not turn else "car"
                put(name, x, z, side * turn if side > 0 else math.pi + turn)
    return placed


def paint_vehicles(canvas: Canvas, placed: list[Placed], traffic: Traffic) -> None:
    """Paint the placed vehicles as instances."""
    for item in placed:
        number = traffic.new(item.name, f"{item.name}s" if item.name != "bus" else "buses", (item.x, item.z))
        item.vehicle.paint(canvas, (item.x, 0.0, item.z), item.heading, ID[item.name], number)


def paint_people(canvas: Canvas, street: Street, rng: np.random.Generator, traffic: Traffic) -> None:
    """People on the sidewalks and crossings, riders on the road, bicycles left at the kerb."""
    for _ in range(rng.integers(3, 11)):
        side = -1 if rng.random() < 0.5 else 1
        x0, x1 = street.pavement(side)
        x, z = float(rng.uniform(x0 + 0.3, x1 - 0.3)), float(7 + 45 * rng.random() ** 1.3)
        group = 1 + (rng.random() < 0.3) + (rng.random() < 0.12)
        for k in range(group):
            y = 0.0 if street.crossed(z, z) else street.curb_height
            _person(canvas, x + 0.62 * k, z + 0.2 * k, y, rng, traffic)
    if street.crossing is not None:
        for _ in range(rng.integers(0, 4)):
            x = float(rng.uniform(street.left_kerb, street.right_kerb))
            _person(canvas, x, street.crossing - 2.2 + float(rng.uniform(-0.8, 0.8)), 0.0, rng, traffic)
    for kind, chance in (("bicycle", 0.75), ("bicycle", 0.4), ("motorcycle", 0.7), ("motorcycle", 0.25)):
        if rng.random() < chance:
            along = rng.random() < 0.55
            if along:
                x = street.right_kerb - 0.7 if rng.random() < 0.6 else street.left_kerb + 0.7
                x += float(rng.uniform(-0.2, 0.3))
            else:
                x = float(rng.uniform(street.left_kerb + 0.5, street.right_kerb - 0.5))
            _rider(canvas, kind, x, float(6.5 + 22 * rng.random() ** 1.5), 0.0, not along, True, rng, traffic)
    for kind, chance in (("bicycle", 0.45), ("bicycle", 0.3), ("motorcycle", 0.35)):
        if rng.random() < chance:
            side = -1 if rng.random() < 0.5 else 1
            x0, x1 = street.pavement(side)
            z = float(rng.uniform(8, 28))
            y = 0.0 if street.crossed(z, z) else street.curb_height
            _rider(canvas, kind, float(rng.uniform(x0 + 0.8, x1 - 0.8)), z, y, True, False, rng, traffic)


def _clothes(rng: np.random.Generator) -> np.ndarray:
    colours = np.zeros((sprites.PARTS, 3), np.float32)
    colours[sprites.SKIN] = colour(*_SKINS[rng.integers(len(_SKINS))]) * np.float32(0.9)
    colours[sprites.HAIR] = colour(*((40, 30, 24), (90, 64, 40), (24, 24, 26), (150, 120, 80))[rng.integers(4)])
    colours[sprites.COAT] = colour(*_COATS[rng.integers(len(_COATS))])
    colours[sprites.TROUSERS] = colour(*_TROUSERS[rng.integers(len(_TROUSERS))])
    colours[sprites.SHOES], colours[sprites.BAG] = colour(40, 36, 34), colour(92, 60, 44)
    return colours


def _person(canvas: Canvas, x: float, z: float, y: float, rng: np.random.Generator, traffic: Traffic) -> None:
    colours = _clothes(rng)
    sprite, scale, flip = sprites.person(int(rng.integers(4))), float(rng.uniform(0.85, 1.08)), bool(rng.random() < 0.5)
    if not traffic.free(x, z, 0.25, 0.15):
        return
    number = traffic.new("person", "pedestrians", (x, z))
    instances = np.full(sprites.PARTS, number, np.uint32)
    instances[0] = 0
    canvas.sprite(sprite, (x, y, z), scale, colours, np.full(sprites.PARTS, ID["person"], np.uint8), instances, flip)


def _rider(
    canvas: Canvas, kind: str, x: float, z: float, y: float, side: bool, ridden: bool, rng: np.random.Generator,
    traffic: Traffic,
) -> None:  # fmt: skip
    colours = _clothes(rng)
    colours[sprites.WHEEL], colours[sprites.HUB] = (
        colour(26, 26, 28),
        colour(96, 98, 100) if kind == "bicycle" else colour(54, 54, 58),
    )
    colours[sprites.BODY] = colour(*PAINTS[rng.integers(len(PAINTS))])
    colours[sprites.METAL], colours[sprites.LAMP] = (
        colour(116, 118, 122),
        colour(230, 226, 200) if rng.random() < 0.5 else colour(190, 30, 26),
    )
    if ridden:  # a helmet
        colours[sprites.HAIR] = colour(*((60, 90, 170), (210, 210, 206), (30, 30, 34), (190, 40, 40))[rng.integers(4)])
    flip = bool(rng.random() < 0.5)
    if not traffic.free(x, z, 0.9 if side else 0.4, 0.4 if side else 0.9):
        return
    vehicle = traffic.new(kind, "vehicles", (x, z))
    labels, instances = np.full(sprites.PARTS, ID[kind], np.uint8), np.full(sprites.PARTS, vehicle, np.uint32)
    if ridden:
        rider = traffic.new("rider", f"{kind[:-1]}ists", (x, z))
        labels[: sprites.WHEEL], instances[: sprites.WHEEL] = ID["rider"], rider
    instances[0] = 0
    canvas.sprite(sprites.cycle(kind, side, ridden), (x, y, z), 1.0, colours, labels, instances, flip)


def paint_shadows(canvas: Canvas, placed: list[Placed], weather: Weather) -> None:
    """Soft dark ground below the vehicles; harder under direct sun."""
    for item in placed:
        half = item.vehicle.width / 2 + 0.25, item.vehicle.length / 2 + 0.25
        canvas.shadow((item.x, item.z), half, item.heading, 0.42 + 0.25 * weather.direct)
