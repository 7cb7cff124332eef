"""The camera of a rendered frame: intrinsics, pose and viewing rays.

World frame: x right, y up, z along the street, in metres; the camera stands above the origin.
Camera frame: x right, y down, z forward. Pixel (row, column) is seen through its centre (row + 0.5, column + 0.5).
Angles are in radians: pitch is positive downwards, yaw positive to the left, roll positive clockwise.
"""

import math
from dataclasses import asdict, dataclass
from functools import cached_property

import numpy as np

FX, FY, U0, V0, COLUMNS, ROWS = 1590.83437, 1592.79032, 771.31406, 360.79945, 1440, 720
"""Intrinsics in pixels of the published Synscapes samples; Cityscapes has the same ones at 2048 x 1024."""

PITCH, YAW, MOUNT_X, MOUNT_Y, HEIGHT = 0.038, -0.0195, 1.7, 0.1, 1.22
"""Extrinsics of the same samples: radians and metres in the vehicle's frame (x forward, y left, z up)."""


@dataclass(frozen=True)
class Rig:
    """A camera as the metadata states it; intrinsics in pixels, angles in radians, positions in metres."""

    fx: float
    fy: float
    u0: float
    v0: float
    resx: int
    resy: int
    pitch: float
    roll: float
    yaw: float
    x: float
    y: float
    z: float

    @cached_property
    def axes(self) -> np.ndarray:
        """Right, up and forward direction of the camera in the world, float64 (3, 3), one per row."""
        cp, sp = math.cos(self.pitch), math.sin(self.pitch)
        cy, sy = math.cos(self.yaw), math.sin(self.yaw)
        cr, sr = math.cos(self.roll), math.sin(self.roll)
        right, up, forward = np.array([[cy, 0, sy], [-sp * sy, cp, sp * cy], [-cp * sy, -sp, cp * cy]])
        return np.stack([cr * right - sr * up, sr * right + cr * up, forward])

    def rays(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """World directions through all pixel centres, three float32 (H, W), scaled to planar depth 1.

        A point at planar depth s is the camera's position plus s times the ray.
        """
        across = ((np.arange(self.resx) + 0.5 - self.u0) / self.fx)[None, :]
        down = ((np.arange(self.resy) + 0.5 - self.v0) / self.fy)[:, None]
        right, up, forward = self.axes
        dx, dy, dz = ((across * right[k] - down * up[k] + forward[k]).astype(np.float32) for k in range(3))
        return dx, dy, dz

    def to_camera(self, points: np.ndarray) -> np.ndarray:
        """Camera coordinates of world points: right, down, forward; float64 (N, 3) from (N, 3), metres."""
        offset = points - np.array((0.0, self.z, 0.0))
        turned = (offset[:, None, :] * self.axes).sum(axis=2)
        turned[:, 1] *= -1.0
        return turned

    def to_image(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Columns and rows (continuous, pixels) of points in the camera frame, in front of the camera."""
        depth = points[:, 2]
        return points[:, 0] / depth * self.fx + self.u0, points[:, 1] / depth * self.fy + self.v0

    def metadata(self) -> dict[str, dict[str, float]]:
        """The camera as the datasets describe it: "intrinsic" and "extrinsic" parameters by name."""
        values = list(asdict(self).items())
        return {"intrinsic": dict(values[:6]), "extrinsic": dict(values[6:])}


def sample_rig(rng: np.random.Generator, size: tuple[int, int], spread: float) -> Rig:
    """Draw a camera near the published one, scaled to `size` (rows, columns).

    `spread` 1 varies it from frame to frame as a procedural data set does; near 0 it is one car's calibrated camera.
    """
    rows, columns = size
    scale = columns / COLUMNS

    def vary(value: float, width: float) -> float:
        return round(float(value + spread * rng.uniform(-width, width)), 6)

    zoom = 1.0 + spread * rng.uniform(-0.04, 0.04)
    fx, fy = round(FX * scale * zoom, 5), round(FY * scale * zoom, 5)
    u0, v0 = vary(U0 * scale, 0.01 * columns), vary(V0 / ROWS * rows, 0.01 * rows)
    pitch, roll, yaw = vary(PITCH, 0.012), vary(0.0, 0.006), vary(YAW, 0.03)
    x, y, z = vary(MOUNT_X, 0.2), vary(MOUNT_Y, 0.05), vary(HEIGHT, 0.15)
    return Rig(fx, fy, u0, v0, columns, rows, pitch, roll, yaw, x, y, z)
