"""Poles, lamps, traffic lights, signs and trees along the kerbs."""

import math

import numpy as np

from foggy_synscapes.standin import sprites, textures
from foggy_synscapes.standin.canvas import Canvas, Point, Solid
from foggy_synscapes.standin.street import Street
from foggy_synscapes.standin.style import Style, colour, palette

STATIC = 4
"""labelId of street clutter: void in the evaluation."""

_GREYS = "808284 5e6264 969694 464c48"
_LEAVES = "425c28 36542a 546630 70682c 30482c 8c5c28"


def paint_furniture(canvas: Canvas, street: Street) -> None:
    """Scatter what stands along a street; positions follow the kerbs and the crossing."""
    style, rng, level = canvas.style, canvas.style.rng, street.curb_height

    def along(first: float, last: float) -> float:
        z = first + (last - first) * rng.random() ** 1.4
        return max(6.0, street.crossing[0] - 2.0) if street.crossed(z - 1, z + 1) else z

    for side in street.sides:
        sign, edge = side.sign, side.kerb + side.sign * 0.45
        for z in np.arange(rng.uniform(9, 22), 100, rng.uniform(20, 28)).tolist():
            if rng.random() < 0.85 and not street.crossed(z - 1, z + 1):
                canvas.sprite(sprites.post("lamp"), (edge - sign, level, z), _post_colours(style), flip=sign > 0)
        for _ in range(rng.integers(2, 6)):
            _paint_sign(canvas, (edge + sign * rng.uniform(0, 0.6), level, along(8, 60)))
        if rng.random() < 0.45:
            trees = np.arange(rng.uniform(10, 24), 110, rng.uniform(9, 16)).tolist()
        else:
            trees = rng.uniform(12, 90, rng.integers(1, 4)).tolist()
        for z in trees:
            # Near trees would hide the little blue sky that a street shows.
            if not street.crossed(z - 1, z + 1) and not (style.weather.blue and z < 40):
                foot = (side.back + sign * side.verge * 0.5, 0.0, z) if side.verge else (edge + sign * 0.4, level, z)
                _paint_plant(canvas, foot, int(rng.integers(6)))
        for _ in range(rng.integers(0, 4) if side.verge else 0):
            foot = side.back + sign * rng.uniform(0.6, side.verge), 0.0, along(9, 50)
            _paint_plant(canvas, foot, int(rng.integers(6, 8)))
        for _ in range(rng.integers(0, 4)):
            colours = _post_colours(style)
            post = sprites.post(rng.choice(["pole", "bollard", "bollard"]))
            canvas.sprite(post, (edge, level, along(7, 45)), colours)
        if rng.random() < 0.4:
            place = side.back - sign * 0.6, level, along(8, 40), 0.0
            litter_bin = Solid((-0.35, 0.35), (0, 1.1), (-0.35, 0.35))
            canvas.solid(litter_bin, textures.plain(style, "46544a", style.grain), STATIC, place)
    z = street.crossing[0] - 1.0
    if rng.random() < 0.75 and math.isinf(z):
        z = rng.uniform(12, 40)
    for side in street.sides if z < math.inf else ():
        colours = _post_colours(style)
        light = sprites.traffic_light(rng.integers(3), rng.random() < 0.4)
        x = side.kerb + side.sign * 0.4 - (side.sign * 1.7 if light.width > 2 else 0)
        canvas.sprite(light, (x, level, z), colours, flip=side.sign < 0)


def _post_colours(style: Style) -> np.ndarray:
    return sprites.coloured({sprites.POST: style.pick(_GREYS)})


def _paint_sign(canvas: Canvas, foot: Point) -> None:
    style, rng = canvas.style, canvas.style.rng
    kind = list(sprites.SIGNS)[rng.integers(len(sprites.SIGNS))]
    colours, parts = _post_colours(style), [sprites.RIM, sprites.PLATE, sprites.SYMBOL]
    colours[parts] = palette(sprites.SIGNS[kind][0]) * np.float32(0.92)
    if rng.random() < 0.2:  # seen from behind
        colours[parts] = colour("96989a")
    canvas.sprite(sprites.sign(kind), foot, colours, scale=rng.uniform(0.9, 1.1))


def _paint_plant(canvas: Canvas, foot: Point, kind: int) -> None:
    style, rng = canvas.style, canvas.style.rng
    leaf = style.pick(_LEAVES) * np.float32(rng.uniform(0.8, 1.15))
    lights = {sprites.LEAF: 1.0, sprites.LEAF_LIT: 1.35, sprites.LEAF_DARK: 0.6}
    colours = sprites.coloured({part: leaf * np.float32(light) for part, light in lights.items()})
    canvas.sprite(sprites.tree(kind), foot, colours, scale=rng.uniform(0.7, 1.3), flip=rng.random() < 0.5)
