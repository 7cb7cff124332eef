"""Frames of the stand-in as scenes of light: linear radiance, distances and the airlight."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from foggy_synscapes.atlas.cells import GROUND, SEED, SIZE, SKY
from foggy_synscapes.camera import Camera
from foggy_synscapes.fog.airlight import estimate
from foggy_synscapes.fog.radiance import linear
from foggy_synscapes.labels import CLASSES, LABEL_IDS
from foggy_synscapes.standin.layouts.synscapes import scene as drawn

FARTHEST = 1000.0
"""Metres: what lies farther, such as the sky's dome, is put there; at the thinnest fog 0.7 % of its light arrive."""


@dataclass(frozen=True)
class Scene:
    """A frame of the stand-in.

    image : uint8 (H, W, 3); depth : float32 (H, W), planar metres up to FARTHEST
    camera : its principal point in the middle, one focal length
    pitch : radians, positive downwards; height : metres of the camera above the road
    """

    image: np.ndarray
    depth: np.ndarray
    labels: np.ndarray
    camera: Camera
    pitch: float
    height: float

    @property
    def airlight(self) -> tuple[int, int, int]:
        """As estimated from the image: three levels."""
        return estimate(self.image).levels

    def surround(self, name: str) -> np.ndarray:
        """Radiance that comes from where the frame does not reach, linear (3,), at a surround of `cells`."""
        if name == SKY and self._of("sky").any():
            return linear(self.image)[self._of("sky")].mean(axis=0)
        return linear(np.array(self.airlight, np.uint8))

    def ground(self, name: str) -> np.ndarray | None:
        """Radiance of the plane below the horizon, linear (3,); None where there is none."""
        road = self._of("road")
        return linear(self.image)[road].mean(axis=0) if name == GROUND and road.any() else None

    def _of(self, label: str) -> np.ndarray:
        return self.labels == LABEL_IDS[CLASSES.index(label)]


@cache
def scene(number: int) -> Scene:
    """A frame of the stand-in, by its number from 0."""
    found = drawn(SEED, SIZE, number)
    rows, columns = SIZE
    camera = Camera(found.rig.fx, found.rig.fx, columns / 2, rows / 2, columns, rows)
    depth = np.minimum(found.depth, np.float32(FARTHEST))
    return Scene(found.rgb, depth, found.label_ids, camera, found.rig.pitch, found.rig.z)
