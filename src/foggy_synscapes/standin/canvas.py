"""The frame being painted: nearest surface wins, pixel by pixel.

Two primitives are enough for a street: convex solids (boxes with cut corners) and upright sprites.
Both know the exact planar depth of every pixel and keep a record of the whole extent of each instance,
hidden or not, for the metadata.
"""

import math
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import reduce
from itertools import product
from operator import add
from typing import Any

import numpy as np

from foggy_synscapes.standin.camera import Rig
from foggy_synscapes.standin.sprites import LABELS, Sprite
from foggy_synscapes.standin.style import Style

SKY_NEAR, SKY_FAR = 7900.0, 8900.0
"""Planar depth in metres of the sky dome in the published samples."""

FARTHEST = 480.0
"""Metres beyond which only sky is: the published samples have nothing between 500 m and 7 km."""

LEFT, RIGHT, BOTTOM, TOP, FRONT, BACK = range(6)
"""Faces of a solid; the front faces towards -z."""

Point = tuple[float, float, float]
"""x, y and z in metres."""

Place = tuple[float, float, float, float]
"""x, y and z in metres, and a turn about the vertical axis in radians."""

ORIGIN = (0.0, 0.0, 0.0, 0.0)

STRIDE = 10000
"""Road users are numbered labelId * STRIDE + n, so that all three bytes of the encoding occur."""


@dataclass
class Hit:
    """Where rays meet a solid, one entry per pixel: face, local coordinates and planar depth in metres."""

    face: np.ndarray
    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    depth: np.ndarray


Shader = Callable[[Hit], tuple[np.ndarray, np.ndarray | None]]
"""Colours float32 (N, 3) in [0, 1] of the hits, and which of them are solid (None: all)."""


@dataclass(frozen=True)
class Solid:
    """A box by the ends of its edges in local coordinates, metres.

    Planes (face, nx, ny, nz, c) cut it to n . p <= c; what they lay bare is shaded as that face.
    """

    x: tuple[float, float]
    y: tuple[float, float]
    z: tuple[float, float]
    cuts: tuple[tuple[int, float, float, float, float], ...] = ()

    def planes(self) -> list[tuple[int, float, float, float, float]]:
        """All bounding planes, the six of the box first."""
        (x0, x1), (y0, y1), (z0, z1) = map(sorted, (self.x, self.y, self.z))
        sides = (LEFT, -1, 0, 0, -x0), (RIGHT, 1, 0, 0, x1)
        levels = (BOTTOM, 0, -1, 0, -y0), (TOP, 0, 1, 0, y1)
        ends = (FRONT, 0, 0, -1, -z0), (BACK, 0, 0, 1, z1)
        return [*sides, *levels, *ends, *self.cuts]

    def corners(self) -> np.ndarray:
        """The eight corners of the box, (8, 3), z changing fastest."""
        return np.array(list(product(self.x, self.y, self.z)))


@dataclass
class Trace:
    """What an instance would cover if nothing stood before it, (H, W), its planar depths in metres, and its boxes."""

    extent: np.ndarray
    near: float = math.inf
    far: float = 0.0
    corners: list[np.ndarray] = field(default_factory=list)

    def add(self, pixels: np.ndarray, depth: np.ndarray | np.floating) -> None:
        """Take in pixels, given by their places in the flat image."""
        if pixels.size:
            self.extent.reshape(-1)[pixels] = True
            self.near, self.far = min(self.near, float(depth.min())), max(self.far, float(depth.max()))


class Canvas:
    """RGB in [0, 1], planar depth and numbers (labelIds, or those of road users) of a frame: (H, W, 3) and (H, W)."""

    def __init__(self, rig: Rig, style: Style) -> None:
        self.rig, self.style = rig, style
        self.rays = rig.rays()
        size = rig.resy, rig.resx
        self.rgb = np.zeros((*size, 3), np.float32)
        self.depth = np.full(size, np.inf, np.float32)
        self.number = np.zeros(size, np.uint32)
        self.traces = defaultdict[int, Trace](lambda: Trace(np.zeros(size, bool)))
        self._pixels = np.arange(self.depth.size).reshape(size)

    def paint(self, pixels: np.ndarray, depth: Any, rgb: np.ndarray, number: Any) -> None:
        """Paint pixels, given by their places in the flat image; all but `rgb` may be one for all of them."""
        self.rgb.reshape(-1, 3)[pixels] = rgb
        self.depth.reshape(-1)[pixels] = depth
        self.number.reshape(-1)[pixels] = number

    def solid(self, solid: Solid, shader: Shader, number: int, place: Place = ORIGIN) -> None:
        """Paint a solid."""
        *position, heading = place
        cos, sin = math.cos(heading), math.sin(heading)
        x, y, z = solid.corners().T
        x, z = _turned(cos, -sin, x, z)
        world = np.stack([x, y, z], axis=1) + position
        if number > STRIDE:
            self.traces[number].corners.append(self.rig.to_camera(world))
        window = self._window(world)
        if window is None:
            return
        dx, dy, dz = (ray[window] for ray in self.rays)
        dx, dz = _turned(cos, sin, dx, dz)
        x, z = _turned(cos, sin, -position[0], -position[2])
        y = self.rig.z - position[1]
        near, far = np.zeros(dx.shape, np.float32), np.full(dx.shape, np.inf, np.float32)
        entered = np.zeros(dx.shape, np.uint8)
        planes = solid.planes()
        lights = np.zeros(len(planes), np.float32)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            for plane, (_, nx, ny, nz, c) in enumerate(planes):
                weighed = [(weight, ray) for weight, ray in ((nx, dx), (ny, dy), (nz, dz)) if weight]
                along = reduce(add, [ray if weight == 1 else ray * np.float32(weight) for weight, ray in weighed])
                gap = np.float32(c - (nx * x + ny * y + nz * z))
                distance = gap / along
                if gap >= 0:  # the camera is behind this plane: rays can only leave through it
                    np.putmask(distance, along <= 0, np.inf)
                    np.minimum(far, distance, out=far)
                else:
                    wx, wz = _turned(cos, -sin, nx, nz)
                    lights[plane] = self.style.weather.light(wx, ny, wz)
                    np.putmask(distance, along >= 0, np.inf)
                    np.putmask(entered, distance > near, plane)
                    np.maximum(near, distance, out=near)
        hit = (near < far) & (near > 0.05) & (near < FARTHEST)
        if number < STRIDE:  # of a road user the hidden pixels count too
            hit &= near < self.depth[window]
        inner = np.flatnonzero(hit)
        if not inner.size:
            return
        arrays = (near, entered, dx, dy, dz, self._pixels[window])
        near, entered, dx, dy, dz, pixels = (array.take(inner) for array in arrays)
        face = np.array([face for face, *_ in planes], np.uint8)[entered]
        rgb, keep = shader(Hit(face, x + near * dx, y + near * dy, z + near * dz, near))
        rgb *= lights[entered][:, None]
        if keep is not None:
            pixels, near, rgb = pixels[keep], near[keep], rgb[keep]
        if number > STRIDE:
            self.traces[number].add(pixels, near)
            front = near < self.depth.take(pixels)
            pixels, near, rgb = pixels[front], near[front], rgb[front]
        self.paint(pixels, near, rgb, number)

    def sprite(
        self,
        sprite: Sprite,
        foot: Point,
        colours: np.ndarray,
        numbers: np.ndarray = LABELS,
        scale: float = 1.0,
        flip: bool = False,
    ) -> None:
        """Paint an upright sprite that faces the camera, its foot at a world position.

        `colours` float32 (P, 3) and `numbers` (P,) are looked up by the sprite's parts; part 0 is transparent.
        """
        x, y, depth = self.rig.to_camera(np.array([foot]))[0].tolist()
        width, height = sprite.width * scale, sprite.height * scale
        per_column, per_row = depth / self.rig.fx, depth / self.rig.fy
        left, top = (x - width / 2) / per_column + self.rig.u0, (y - height) / per_row + self.rig.v0
        (end, right), (high, wide) = self.depth.shape, sprite.parts.shape
        columns = np.arange(max(0, math.floor(left)), min(right, math.ceil(left + width / per_column) + 1))
        rows = np.arange(max(0, math.floor(top)), min(end, math.ceil(top + height / per_row) + 1))
        across = np.floor((columns + 0.5 - left) * per_column / width * wide).astype(int)
        down = np.floor((rows + 0.5 - top) * per_row / height * high).astype(int)
        columns, across = (a[(across >= 0) & (across < wide)] for a in (columns, across))
        rows, down = (a[(down >= 0) & (down < high)] for a in (rows, down))
        pick = np.ix_(down, wide - 1 - across if flip else across)
        parts, shade = sprite.parts[pick], sprite.shade[pick]
        inside = parts > 0
        parts, shade, pixels = parts[inside], shade[inside], (rows[:, None] * right + columns)[inside]
        away = np.float32(depth)
        box = np.array(list(product((x - width / 2, x + width / 2), (y, y - height), (depth, depth + 0.4))))
        for number in {*numbers.tolist()}:
            if number > STRIDE:
                self.traces[number].corners.append(box)
                self.traces[number].add(pixels[numbers[parts] == number], away)
        front = away < self.depth.take(pixels)
        parts, shade, pixels = parts[front], shade[front], pixels[front]
        upright = self.style.weather.ambient + 0.45 * self.style.weather.direct
        rgb = colours[parts] * (shade * np.float32(upright))[:, None]
        self.paint(pixels, away, rgb, numbers[parts])

    def shadow(self, centre: tuple[float, float], half: tuple[float, float], heading: float, strength: float) -> None:
        """Darken the ground around (x, z) with a soft ellipse of half axes `half`, metres."""
        reach = 1.3 * max(half)
        ends = [(middle - reach, middle + reach) for middle in centre]
        window = self._window(np.array(list(product(ends[0], (0.0,), ends[1]))))
        if window is None:
            return
        near = np.minimum(self.depth[window], 1000)
        x, z = (near * ray[window] - middle for ray, middle in zip(self.rays[::2], centre, strict=True))
        u, v = _turned(math.cos(heading), math.sin(heading), x, z)
        u, v = u / half[0], v / half[1]
        dark = 1.0 - strength * np.clip(1.6 - 1.2 * (u * u + v * v), 0, 1)
        self.rgb[window] *= dark[:, :, None].astype(np.float32)

    def _window(self, points: np.ndarray) -> tuple[slice, slice] | None:
        # Rows and columns that world points can touch; everything stands in front of the camera.
        ranges = []
        columns, rows = self.rig.to_image(self.rig.to_camera(points))
        for places, length in zip((rows, columns), self.depth.shape, strict=True):
            first, end = max(0, math.floor(places.min())), min(length, math.ceil(places.max()) + 1)
            if first >= end:
                return None
            ranges.append(slice(first, end))
        return ranges[0], ranges[1]


def _turned(cos: float, sin: float, x: Any, z: Any) -> tuple[Any, Any]:
    # Turned about the vertical axis.
    return (cos * x - sin * z, sin * x + cos * z) if sin else (x, z)
