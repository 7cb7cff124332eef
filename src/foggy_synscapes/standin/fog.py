"""Fog in the stand-in's own photographs: a little uneven, and of densities that no training set uses.

It stands apart from the fog core on purpose: these pictures play the part of data from elsewhere, and a change
of the fog core must not draw them anew.
"""

import numpy as np

from foggy_synscapes.standin import stereo
from foggy_synscapes.standin.camera import Rig
from foggy_synscapes.standin.noise import upsample
from foggy_synscapes.standin.render import Scene

UNEVENNESS = 0.22
"""Standard deviation of the local beta, as a share of the mean: mild, as fog banks on a street are."""


def ray_length(depth: np.ndarray, rig: Rig) -> np.ndarray:
    """Distance along the ray in metres, float64 (H, W), from planar depth."""
    x = (np.arange(rig.resx) + 0.5 - rig.u0) / rig.fx
    y = (np.arange(rig.resy) + 0.5 - rig.v0) / rig.fy
    return depth * np.sqrt(1 + x[None, :] ** 2 + y[:, None] ** 2)


def photograph(scene: Scene, beta: float, rng: np.random.Generator) -> np.ndarray:
    """The scene in fog as a camera sees it, uint8 (H, W, 3); beta in 1/m."""
    rows, columns = scene.depth.shape
    local = beta * np.clip(1 + UNEVENNESS * upsample(rng.standard_normal((4, 5)), (rows, columns)), 0.4, 1.8)
    grey = rng.uniform(0.72, 0.92)
    airlight = grey * np.array([1.0, 1.0, 1.0]) + rng.uniform(-0.02, 0.02, 3)
    clear = np.exp(-local * ray_length(scene.depth, scene.rig))[:, :, None]
    foggy = clear * (scene.rgb / 255.0) + (1 - clear) * airlight
    foggy += 0.007 * rng.standard_normal(foggy.shape)
    return np.clip(np.floor(foggy * 255 + 0.5), 0, 255).astype(np.uint8)


def from_stereo(scene: Scene, disparity: np.ndarray, betas: list[float]) -> list[np.ndarray]:
    """Fog on a clear photograph from its measured disparity (uint16, see `stereo.measure`), one image per beta in 1/m.

    The atmospheric light is the mean of the brightest thousandth of the image.
    """
    length = ray_length(stereo.to_depth(stereo.complete(disparity), scene.rig.fx), scene.rig)
    clear = scene.rgb / 255.0
    darkest = clear.min(axis=2).ravel()
    brightest = np.argsort(darkest, kind="stable")[-max(1, darkest.size // 1000) :]
    airlight = clear.reshape(-1, 3)[brightest].mean(axis=0)
    foggy = []
    for beta in betas:
        transmittance = np.exp(-beta * length)[:, :, None]
        mixed = transmittance * clear + (1 - transmittance) * airlight
        foggy.append(np.clip(np.floor(mixed * 255 + 0.5), 0, 255).astype(np.uint8))
    return foggy
