"""Poles, lamps, traffic lights, signs and trees along the kerbs."""

import numpy as np

from foggy_synscapes.standin import sprites, textures
from foggy_synscapes.standin.canvas import Canvas, Solid
from foggy_synscapes.standin.sky import Weather
from foggy_synscapes.standin.street import ID, STATIC, Street
from foggy_synscapes.standin.textures import colour

_GREY = ((128, 130, 132), (94, 98, 100), (150, 150, 148), (70, 76, 72))
_SIGN = {
    "limit": ((196, 24, 28), (240, 240, 236), (24, 24, 24)),
    "triangle": ((196, 24, 28), (240, 240, 236), (24, 24, 24)),
    "yield": ((196, 24, 28), (240, 240, 236), (240, 240, 236)),
    "blue": ((28, 80, 170), (28, 80, 170), (240, 240, 240)),
    "priority": ((240, 240, 236), (240, 196, 30), (240, 196, 30)),
    "stop": ((196, 24, 28), (196, 24, 28), (240, 240, 236)),
    "board": ((240, 240, 240), (28, 80, 170), (240, 240, 240)),
    "direction": ((240, 240, 240), (30, 70, 150), (236, 236, 236)),
}
_LEAVES = ((66, 92, 40), (54, 84, 42), (84, 102, 48), (112, 104, 44), (48, 72, 44), (140, 92, 40))


def _post_colours(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    colours, labels = np.zeros((9, 3), np.float32), np.full(9, ID["pole"], np.uint8)
    colours[sprites.POST] = colour(*_GREY[rng.integers(len(_GREY))])
    return colours, labels


def paint_furniture(canvas: Canvas, street: Street, rng: np.random.Generator, weather: Weather, grain: float) -> None:
    """Scatter what stands along a street; positions follow the kerbs and the crossing."""
    for side in (-1, 1):
        inner, outer = sorted(street.pavement(side), key=abs)
        edge = inner + side * 0.45
        for z in np.arange(rng.uniform(9, 22), 100, rng.uniform(20, 28)).tolist():
            if rng.random() < 0.85:
                _lamp(canvas, street, edge, z, side, rng)
        for _ in range(rng.integers(2, 6)):
            _sign(canvas, edge + side * float(rng.uniform(0, 0.6)), _along(street, rng, 8, 60), street.curb_height, rng)
        if rng.random() < 0.45:
            trees = np.arange(rng.uniform(10, 24), 110, rng.uniform(9, 16)).tolist()
        else:
            trees = rng.uniform(12, 90, rng.integers(1, 4)).tolist()
        behind = street.verges[0 if side < 0 else 1]
        for z in trees:
            x = outer + side * behind * 0.5 if behind else edge + side * 0.4
            # Near trees would hide the little blue sky that a street shows.
            if not street.crossed(z - 1, z + 1) and not (weather.blue and z < 40):
                _tree(canvas, float(x), z, 0.0 if behind else street.curb_height, int(rng.integers(6)), rng)
        for _ in range(rng.integers(0, 4) if behind else 0):
            _tree(
                canvas,
                outer + side * float(rng.uniform(0.6, behind)),
                _along(street, rng, 9, 50),
                0.0,
                int(rng.integers(6, 8)),
                rng,
            )
        for _ in range(rng.integers(0, 4)):
            colours, labels = _post_colours(rng)
            colours[sprites.PLATE] = colour(220, 216, 200)
            sprite = sprites.post(str(rng.choice(["pole", "bollard", "bollard"])))
            canvas.sprite(sprite, (edge, street.curb_height, _along(street, rng, 7, 45)), 1.0, colours, labels)
        if rng.random() < 0.4:
            bin_ = Solid((-0.35, 0, -0.35), (0.35, 1.1, 0.35))
            place = (outer - side * 0.6, street.curb_height, _along(street, rng, 8, 40))
            canvas.solid(bin_, place, textures.plain(rng, (70, 84, 74), grain), STATIC)
    lights = [(side, street.crossing - 1.0) for side in (-1, 1)] if street.crossing is not None else []
    if rng.random() < 0.75 and not lights:
        z = float(rng.uniform(12, 40))
        lights = [(-1, z), (1, z)]
    for side, z in lights:
        inner = min(street.pavement(side), key=abs)
        colours, labels = _post_colours(rng)
        labels[sprites.CASE :] = ID["traffic light"]
        colours[sprites.CASE] = colour(26, 28, 28)
        colours[sprites.RED], colours[sprites.AMBER], colours[sprites.GREEN] = (
            colour(255, 60, 40),
            colour(255, 190, 50),
            colour(60, 240, 150),
        )
        sprite = sprites.traffic_light(int(rng.integers(3)), bool(rng.random() < 0.4))
        x = inner + side * 0.4 - (side * 1.7 if sprite.width > 2 else 0)
        canvas.sprite(sprite, (x, street.curb_height, z), 1.0, colours, labels, flip=side < 0)


def _along(street: Street, rng: np.random.Generator, first: float, last: float) -> float:
    z = float(first + (last - first) * rng.random() ** 1.4)
    if street.crossing is None or not street.crossed(z - 1, z + 1):
        return z
    return max(6.0, street.crossing - 2.0)


def _lamp(canvas: Canvas, street: Street, x: float, z: float, side: int, rng: np.random.Generator) -> None:
    if street.crossed(z - 1, z + 1):
        return
    colours, labels = _post_colours(rng)
    canvas.sprite(sprites.post("lamp"), (x - side * 1.0, street.curb_height, z), 1.0, colours, labels, flip=side > 0)


def _sign(canvas: Canvas, x: float, z: float, y: float, rng: np.random.Generator) -> None:
    kind = sprites.SIGNS[rng.integers(len(sprites.SIGNS))]
    colours, labels = _post_colours(rng)
    labels[[sprites.PLATE, sprites.RIM, sprites.SYMBOL]] = ID["traffic sign"]
    for part, rgb in zip((sprites.RIM, sprites.PLATE, sprites.SYMBOL), _SIGN[kind], strict=True):
        colours[part] = colour(*rgb) * np.float32(0.92)
    if rng.random() < 0.2:  # seen from behind
        colours[[sprites.PLATE, sprites.RIM, sprites.SYMBOL]] = colour(150, 152, 154)
    canvas.sprite(sprites.sign(kind), (x, y, z), float(rng.uniform(0.9, 1.1)), colours, labels)


def _tree(canvas: Canvas, x: float, z: float, y: float, kind: int, rng: np.random.Generator) -> None:
    leaf = colour(*_LEAVES[rng.integers(len(_LEAVES))]) * np.float32(rng.uniform(0.8, 1.15))
    colours = np.zeros((5, 3), np.float32)
    colours[sprites.TRUNK], colours[sprites.LEAF] = colour(74, 60, 48), leaf
    colours[sprites.LEAF_LIT], colours[sprites.LEAF_DARK] = leaf * np.float32(1.35), leaf * np.float32(0.6)
    labels = np.full(5, ID["vegetation"], np.uint8)
    canvas.sprite(sprites.tree(kind), (x, y, z), float(rng.uniform(0.7, 1.3)), colours, labels, flip=rng.random() < 0.5)
