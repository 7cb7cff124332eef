"""Road users: vehicles in their lanes, parked cars, people on the sidewalks and riders."""

import math
from dataclasses import dataclass, field

import numpy as np

from foggy_synscapes.standin import sprites, vehicles
from foggy_synscapes.standin.canvas import STRIDE, Canvas, Point
from foggy_synscapes.standin.street import Street
from foggy_synscapes.standin.style import ID, Style, colour

_CLOTHES = {
    sprites.SKIN: "d6aa8c b48264 785440 e2bca0",
    sprites.HAIR: "281e18 5a4028 18181a 967850",
    sprites.COAT: "282c3c 96282c 506e96 c8c4bc 3c503c 1e1e20 be963c 78466e",
    sprites.TROUSERS: "222636 32466e 1a1a1c 786c58 5a5c60",
}
_HELMETS = "3c5aaa d2d2ce 1e1e22 be2828"


@dataclass
class Traffic:
    """What was placed: for each instance the kind it counts as in the scene keys, and how far away it is, in metres.

    placed : class, shape, half width, half length, x and z of the middle in metres, and heading in radians of each
    taken : rectangles of ground, their middle and half their size in metres
    """

    instances: dict[int, tuple[str, float]] = field(default_factory=dict)
    placed: list[tuple[str, vehicles.Vehicle, float, float, float, float, float]] = field(default_factory=list)
    taken: list[tuple[float, float, float, float]] = field(default_factory=list)

    def new(self, name: str, kind: str, x: float, z: float) -> int:
        """Number a new instance of a class."""
        number = ID[name] * STRIDE + 1
        while number in self.instances:
            number += 1
        self.instances[number] = kind, math.hypot(x, z)
        return number

    def free(self, x: float, z: float, half_x: float, half_z: float) -> bool:
        """Claim a rectangle of ground; False if somebody is there."""
        if any(abs(x - a) < half_x + half_a and abs(z - b) < half_z + half_b for a, b, half_a, half_b in self.taken):
            return False
        self.taken.append((x, z, half_x, half_z))
        return True


def place_vehicles(street: Street, style: Style) -> Traffic:
    """Draw the vehicles and their places, nobody inside another."""
    rng, traffic = style.rng, Traffic()
    left, right = street.sides

    def put(name: str, x: float, z: float, heading: float) -> float:
        vehicle = vehicles.MAKERS[name](style)
        half, end = vehicle[0][0].x[1], max(solid.z[1] for solid, _ in vehicle)
        cos, sin = abs(math.cos(heading)), abs(math.sin(heading))
        half_x, half_z = cos * half + sin * end + 0.2, cos * end + sin * half + 0.4
        if traffic.free(x, z + half_z, half_x, half_z):
            traffic.placed.append((name, vehicle, half, end, x, z + half_z, heading))
        return 2 * half_z

    nearest = 26.0 if style.weather.blue else 9.0  # tall vehicles leave the blue sky in view
    if street.rails is not None:
        put("train", street.rails, rng.uniform(nearest, 34), math.pi)
    for name, chance in (("bus", 0.33), ("truck", 0.36)):
        if rng.random() < chance:
            lane = float(rng.choice(left.lanes + right.lanes[-1:]))
            put(name, lane, rng.uniform(nearest, 32), math.pi if lane in left.lanes else 0.0)
    for side, heading in ((right, 0.0), (left, math.pi)):
        for lane in side.lanes:
            z = rng.uniform(8, 26)
            for _ in range(rng.integers(0, 5)):
                name = rng.choice(["car"] * 10 + ["truck", "bus"]) if z > nearest else "car"
                z += put(name, lane + rng.uniform(-0.25, 0.25), z, heading + rng.uniform(-0.02, 0.02))
                z += rng.uniform(3, 22)
    turn = math.radians(street.parking_angle)
    step = {0: 5.6, 45: 3.6, 90: 2.7}[street.parking_angle]
    for side, heading in ((left, math.pi + turn), (right, turn)):
        if side.parking is None:
            continue
        for z in np.arange(rng.uniform(6, 10), 60, step).tolist():
            if rng.random() < street.parking_presence and not street.crossed(z - 6, z + 6):
                name = "truck" if rng.random() < 0.03 and not turn else "car"
                put(name, side.parking, z, heading)
    return traffic


def paint_vehicles(canvas: Canvas, traffic: Traffic) -> None:
    """Paint the placed vehicles as instances."""
    for name, vehicle, _, _, x, z, heading in traffic.placed:
        number = traffic.new(name, "buses" if name == "bus" else f"{name}s", x, z)
        for solid, shader in vehicle:
            canvas.solid(solid, shader, number, (x, 0.0, z, heading))


def paint_shadows(canvas: Canvas, traffic: Traffic) -> None:
    """Soft dark ground below the vehicles; harder under direct sun."""
    for _, _, half, end, x, z, heading in traffic.placed:
        canvas.shadow((x, z), (half + 0.25, end + 0.25), heading, 0.42 + 0.25 * canvas.style.weather.direct)


def paint_people(canvas: Canvas, street: Street, traffic: Traffic) -> None:
    """People on the sidewalks and crossings, riders on the road, bicycles left at the kerb."""
    rng = canvas.style.rng
    left, right = street.sides

    def pavement(inset: float) -> tuple[float, float]:
        side = right if rng.random() >= 0.5 else left
        x0, x1 = sorted((side.kerb, side.back))
        return x0 + inset, x1 - inset

    def level(z: float) -> float:
        return 0.0 if street.crossed(z, z) else street.curb_height

    for _ in range(rng.integers(3, 11)):
        x, z = rng.uniform(*pavement(0.3)), 7 + 45 * rng.random() ** 1.3
        for k in range(1 + (rng.random() < 0.3) + (rng.random() < 0.12)):
            _paint_person(canvas, (x + 0.62 * k, level(z), z + 0.2 * k), traffic)
    if street.crossing[0] < math.inf:
        for _ in range(rng.integers(0, 4)):
            x = rng.uniform(left.kerb, right.kerb)
            _paint_person(canvas, (x, 0.0, street.crossing[0] - 2.2 + rng.uniform(-0.8, 0.8)), traffic)
    for kind, chance in (("bicycle", 0.75), ("bicycle", 0.4), ("motorcycle", 0.7), ("motorcycle", 0.25)):
        if rng.random() < chance:
            across = rng.random() >= 0.55
            if across:
                x = rng.uniform(left.kerb + 0.5, right.kerb - 0.5)
            else:
                x = (right.kerb - 0.7 if rng.random() < 0.6 else left.kerb + 0.7) + rng.uniform(-0.2, 0.3)
            _paint_cycle(canvas, kind, (x, 0.0, 6.5 + 22 * rng.random() ** 1.5), across, True, traffic)
    for kind, chance in (("bicycle", 0.45), ("bicycle", 0.3), ("motorcycle", 0.35)):
        if rng.random() < chance:
            extent, z = pavement(0.8), rng.uniform(8, 28)
            _paint_cycle(canvas, kind, (rng.uniform(*extent), level(z), z), True, False, traffic)


def _clothes(style: Style) -> np.ndarray:
    colours = sprites.coloured({part: style.pick(codes) for part, codes in _CLOTHES.items()})
    colours[sprites.SKIN] *= np.float32(0.9)
    return colours


def _paint_person(canvas: Canvas, foot: Point, traffic: Traffic) -> None:
    rng, colours = canvas.style.rng, _clothes(canvas.style)
    sprite, scale, flip = sprites.person(rng.integers(4)), rng.uniform(0.85, 1.08), rng.random() < 0.5
    x, _, z = foot
    if traffic.free(x, z, 0.25, 0.15):
        number = traffic.new("person", "pedestrians", x, z)
        canvas.sprite(sprite, foot, colours, np.full(sprites.PARTS, number), scale, flip)


def _paint_cycle(canvas: Canvas, kind: str, foot: Point, across: bool, ridden: bool, traffic: Traffic) -> None:
    style, colours = canvas.style, _clothes(canvas.style)
    colours[sprites.HUB] = colour("606264" if kind == "bicycle" else "36363a")
    colours[sprites.BODY] = style.pick(vehicles.PAINTS)
    colours[sprites.LAMP] = colour("e6e2c8" if style.rng.random() < 0.5 else "be1e1a")
    if ridden:
        colours[sprites.HAIR] = style.pick(_HELMETS)
    flip = style.rng.random() < 0.5
    x, _, z = foot
    if not traffic.free(x, z, 0.9 if across else 0.4, 0.4 if across else 0.9):
        return
    numbers = np.full(sprites.PARTS, traffic.new(kind, "vehicles", x, z))
    if ridden:
        numbers[: sprites.WHEEL] = traffic.new("rider", f"{kind[:-1]}ists", x, z)
    canvas.sprite(sprites.cycle(kind, across, ridden), foot, colours, numbers, flip=flip)
