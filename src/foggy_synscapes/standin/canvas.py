"""The frame being painted: nearest surface wins, pixel by pixel.

Two primitives are enough for a street: convex solids (boxes with cut corners) and upright sprites.
Both know the exact planar depth of every pixel and keep a record of the whole extent of each instance,
hidden or not, for the metadata.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import reduce
from operator import add

import numpy as np

from foggy_synscapes.standin.camera import Rig
from foggy_synscapes.standin.sprites import Sprite

SKY_NEAR, SKY_FAR = 7900.0, 8900.0
"""Planar depth in metres of the sky dome in the published samples."""

FARTHEST = 480.0
"""Metres beyond which only sky is: the published samples have nothing between 500 m and 7 km."""


@dataclass
class Hit:
    """Where rays meet a solid, one entry per pixel: face number, local coordinates and planar depth in metres.

    Faces are 0 left, 1 right, 2 bottom, 3 top, 4 front (towards -z), 5 back, then the extra cuts in order.
    """

    face: np.ndarray
    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    depth: np.ndarray


Shader = Callable[[Hit], tuple[np.ndarray, np.ndarray | None]]
"""Colours float32 (N, 3) in [0, 1] of the hits, and which of them are solid (None: all)."""


@dataclass(frozen=True)
class Solid:
    """A box in local coordinates, metres, and planes (nx, ny, nz, c) that cut it to n . p <= c."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    cuts: tuple[tuple[float, float, float, float], ...] = ()

    def planes(self) -> list[tuple[float, float, float, float]]:
        """All bounding planes, the six of the box first."""
        (x0, y0, z0), (x1, y1, z1) = self.low, self.high
        box = [(-1, 0, 0, -x0), (1, 0, 0, x1), (0, -1, 0, -y0), (0, 1, 0, y1), (0, 0, -1, -z0), (0, 0, 1, z1)]
        return box + list(self.cuts)

    def corners(self) -> np.ndarray:
        """The eight corners of the box, (8, 3)."""
        return np.array([(x, y, z) for x in (self.low[0], self.high[0]) for y in (self.low[1], self.high[1])
                         for z in (self.low[2], self.high[2])])  # fmt: skip


@dataclass
class Trace:
    """What an instance would cover if nothing stood before it, and its box."""

    label: int
    extent: np.ndarray
    near: float = math.inf
    far: float = 0.0
    corners: list[np.ndarray] = field(default_factory=list)


class Canvas:
    """RGB in [0, 1], planar depth, labelIds and instance numbers of a frame, flat arrays of H x W pixels."""

    def __init__(self, rig: Rig, sun: tuple[float, float, float], ambient: float, direct: float) -> None:
        self.rig = rig
        self.rows, self.columns = rig.resy, rig.resx
        self.rays = rig.rays()
        pixels = self.rows * self.columns
        self.rgb = np.zeros((pixels, 3), np.float32)
        self.depth = np.full(pixels, np.inf, np.float32)
        self.label = np.zeros(pixels, np.uint8)
        self.instance = np.zeros(pixels, np.uint32)
        self.traces: dict[int, Trace] = {}
        self.sun, self.ambient, self.direct = sun, ambient, direct

    def window(self, points: np.ndarray) -> tuple[int, int, int, int] | None:
        """Rows and columns (first, end, first, end) that world points can touch; the whole frame if one is behind."""
        local = self.rig.to_camera(points)
        if local[:, 2].max() < 0.2:
            return None
        if local[:, 2].min() < 0.2:
            return 0, self.rows, 0, self.columns
        columns, rows = self.rig.to_image(local)
        top, end = max(0, math.floor(rows.min())), min(self.rows, math.ceil(rows.max()) + 1)
        left, right = max(0, math.floor(columns.min())), min(self.columns, math.ceil(columns.max()) + 1)
        return (top, end, left, right) if top < end and left < right else None

    def light(self, normal: tuple[float, float, float]) -> float:
        """Brightness factor of a surface that faces `normal` (world)."""
        towards = max(0.0, normal[0] * self.sun[0] + normal[1] * self.sun[1] + normal[2] * self.sun[2])
        return self.ambient * (0.88 + 0.12 * normal[1]) + self.direct * towards

    def solid(
        self,
        solid: Solid,
        position: tuple[float, float, float],
        shader: Shader,
        label: int,
        heading: float = 0.0,
        instance: int = 0,
    ) -> None:
        """Paint a solid at a world position, turned by `heading` radians about the vertical axis."""
        cos, sin = math.cos(heading), math.sin(heading)
        corners = solid.corners()
        world = np.stack([cos * corners[:, 0] + sin * corners[:, 2], corners[:, 1],
                          -sin * corners[:, 0] + cos * corners[:, 2]], axis=1) + position  # fmt: skip
        if instance:
            self._trace(instance, label).corners.append(self.rig.to_camera(world))
        window = self.window(world)
        if window is None:
            return
        top, end, left, right = window
        dx, dy, dz = (ray[top:end, left:right] for ray in self.rays)
        lx, lz = (cos * dx - sin * dz, sin * dx + cos * dz) if heading else (dx, dz)
        px, py, pz = -position[0], self.rig.z - position[1], -position[2]
        ox, oz = cos * px - sin * pz, sin * px + cos * pz
        near, far = np.zeros(dx.shape, np.float32), np.full(dx.shape, np.inf, np.float32)
        face = np.zeros(dx.shape, np.uint8)
        planes = solid.planes()
        lights = [0.0] * len(planes)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            for number, (nx, ny, nz, c) in enumerate(planes):
                weighed = [(weight, ray) for weight, ray in ((nx, lx), (ny, dy), (nz, lz)) if weight]
                along = reduce(add, [ray if weight == 1 else ray * np.float32(weight) for weight, ray in weighed])
                gap = np.float32(c - (nx * ox + ny * py + nz * oz))
                distance = gap / along
                if gap >= 0:  # the camera is behind this plane: rays can only leave through it
                    np.putmask(distance, along <= 0, np.inf)
                    np.minimum(far, distance, out=far)
                else:
                    lights[number] = self.light((cos * nx + sin * nz, ny, -sin * nx + cos * nz))
                    np.putmask(distance, along >= 0, np.inf)
                    np.putmask(face, distance > near, number)
                    np.maximum(near, distance, out=near)
        hit = (near < far) & (near > 0.05) & (near < FARTHEST)
        if not instance:
            hit &= near < self.depth.reshape(self.rows, self.columns)[top:end, left:right]
        inner = np.flatnonzero(hit)
        if not inner.size:
            return
        rows, columns = np.divmod(inner, right - left)
        pixels = (rows + top) * self.columns + columns + left
        near, face = near.ravel()[inner], face.ravel()[inner]
        dx, dy, dz = (ray.ravel()[pixels] for ray in self.rays)
        lx, lz = (cos * dx - sin * dz, sin * dx + cos * dz) if heading else (dx, dz)
        rgb, keep = shader(Hit(face, ox + near * lx, py + near * dy, oz + near * lz, near))
        rgb *= np.array(lights, np.float32)[face][:, None]
        if keep is not None:
            pixels, near, rgb = pixels[keep], near[keep], rgb[keep]
        self._paint(pixels, near, rgb, label, instance)

    def sprite(
        self,
        sprite: Sprite,
        foot: tuple[float, float, float],
        scale: float,
        colours: np.ndarray,
        labels: np.ndarray,
        instances: np.ndarray | None = None,
        flip: bool = False,
    ) -> None:
        """Paint an upright sprite that faces the camera, its foot at a world position.

        `colours` float32 (P, 3), `labels` uint8 (P,) and `instances` uint32 (P,) are looked up by the sprite's parts;
        part 0 is transparent.
        """
        x, y, depth = (float(v) for v in self.rig.to_camera(np.array([foot]))[0])
        if depth < 1.0:
            return
        width, height = sprite.width * scale, sprite.height * scale
        per_column, per_row = depth / self.rig.fx, depth / self.rig.fy
        left, top = (x - width / 2) / per_column + self.rig.u0, (y - height) / per_row + self.rig.v0
        columns = np.arange(max(0, math.floor(left)), min(self.columns, math.ceil(left + width / per_column) + 1))
        rows = np.arange(max(0, math.floor(top)), min(self.rows, math.ceil(top + height / per_row) + 1))
        across = np.floor((columns + 0.5 - left) * per_column / width * sprite.parts.shape[1]).astype(int)
        down = np.floor((rows + 0.5 - top) * per_row / height * sprite.parts.shape[0]).astype(int)
        columns, across = (a[(across >= 0) & (across < sprite.parts.shape[1])] for a in (columns, across))
        rows, down = (a[(down >= 0) & (down < sprite.parts.shape[0])] for a in (rows, down))
        if instances is not None:
            box = np.array(
                [(x + a * width / 2, y - b * height, depth + c) for a in (-1, 1) for b in (0, 1) for c in (0, 0.4)]
            )
            for instance in {int(i) for i in instances if i}:
                self._trace(instance, int(labels[instances == instance][0])).corners.append(box)
        if not columns.size or not rows.size:
            return
        pick = np.ix_(down, sprite.parts.shape[1] - 1 - across if flip else across)
        parts = sprite.parts[pick]
        inside = parts > 0
        parts = parts[inside]
        pixels = (rows[:, None] * self.columns + columns[None, :])[inside]
        upright = self.ambient + 0.45 * self.direct
        rgb = colours[parts] * (sprite.shade[pick][inside] * np.float32(upright))[:, None]
        distance = np.full(pixels.shape, depth, np.float32)
        self._paint(pixels, distance, rgb, labels[parts], 0 if instances is None else instances[parts])

    def shadow(self, centre: tuple[float, float], half: tuple[float, float], heading: float, strength: float) -> None:
        """Darken the ground around (x, z) with a soft ellipse of half axes `half`, metres."""
        reach = 1.3 * max(half)
        spot = np.array([(centre[0] + a * reach, 0.0, centre[1] + b * reach) for a in (-1, 1) for b in (-1, 1)])
        window = self.window(spot)
        if window is None:
            return
        top, end, left, right = window
        depth = self.depth.reshape(self.rows, self.columns)[top:end, left:right]
        near = np.minimum(depth, 1000)
        x, z = (
            near * self.rays[0][top:end, left:right] - centre[0],
            near * self.rays[2][top:end, left:right] - centre[1],
        )
        cos, sin = math.cos(heading), math.sin(heading)
        u, v = (cos * x - sin * z) / half[0], (sin * x + cos * z) / half[1]
        dark = 1.0 - strength * np.clip(1.6 - 1.2 * (u * u + v * v), 0, 1)
        self.rgb.reshape(self.rows, self.columns, 3)[top:end, left:right] *= dark[:, :, None].astype(np.float32)

    def _trace(self, instance: int, label: int) -> Trace:
        if instance not in self.traces:
            self.traces[instance] = Trace(label, np.zeros(self.rows * self.columns, bool))
        return self.traces[instance]

    def _paint(
        self,
        pixels: np.ndarray,
        depth: np.ndarray,
        rgb: np.ndarray,
        label: int | np.ndarray,
        instance: int | np.ndarray,
    ) -> None:
        # Instances come with every pixel of theirs, seen or not; the rest of a solid has been tested already.
        numbers = np.unique(instance) if isinstance(instance, np.ndarray) else [instance]
        for number in numbers:
            mine = instance == number if isinstance(instance, np.ndarray) else slice(None)
            if number and depth[mine].size:
                trace = self.traces[int(number)]
                trace.extent[pixels[mine]] = True
                trace.near = min(trace.near, float(depth[mine].min()))
                trace.far = max(trace.far, float(depth[mine].max()))
        if isinstance(label, np.ndarray) or isinstance(instance, np.ndarray) or instance:
            front = depth < self.depth[pixels]
            pixels, depth, rgb = pixels[front], depth[front], rgb[front]
            if isinstance(label, np.ndarray):
                label = label[front]
            if isinstance(instance, np.ndarray):
                instance = instance[front]
        self.rgb[pixels], self.depth[pixels], self.label[pixels] = rgb, depth, label
        self.instance[pixels] = instance
