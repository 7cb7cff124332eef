"""Fog in the stand-in's own photographs: a little uneven, and of densities that no training set uses.

It stands apart from the fog core on purpose: these pictures play the part of data from elsewhere, and a change
of the fog core must not draw them anew.
"""

from dataclasses import replace

import numpy as np

from foggy_synscapes.standin import stereo
from foggy_synscapes.standin.camera import Rig
from foggy_synscapes.standin.render import Scene, render, to_8_bit
from foggy_synscapes.standin.style import upsample

UNEVENNESS = 0.22
"""Standard deviation of the local beta, as a share of the mean: mild, as fog banks on a street are."""


def ray_length(depth: np.ndarray, rig: Rig) -> np.ndarray:
    """Distance along the ray in metres, float64 (H, W), from planar depth."""
    x = (np.arange(rig.resx) + 0.5 - rig.u0) / rig.fx
    y = (np.arange(rig.resy) + 0.5 - rig.v0) / rig.fy
    return depth * np.sqrt(1 + x[None, :] ** 2 + y[:, None] ** 2)


def photograph(key: tuple[int, ...], size: tuple[int, int], beta: float, trains: bool) -> Scene:
    """The scene of (seed, stream, number) in fog of beta in 1/m; `trains`: whether there may be any."""
    scene, rng = render(key, size, real=True, overcast=True, trains=trains), np.random.default_rng((*key, 1))
    local = beta * np.clip(1 + UNEVENNESS * upsample(rng.standard_normal((4, 5)), size), 0.4, 1.8)
    airlight = rng.uniform(0.72, 0.92) + rng.uniform(-0.02, 0.02, 3)
    foggy = _mixed(scene, local * ray_length(scene.depth, scene.rig), airlight)
    return replace(scene, rgb=to_8_bit(foggy + 0.007 * rng.standard_normal(foggy.shape)))


def from_stereo(scene: Scene, disparity: np.ndarray, betas: list[float]) -> list[np.ndarray]:
    """Fog on a clear photograph from its measured disparity (uint16, see `stereo.measure`), one image per beta in 1/m.

    The airlight is the mean of the brightest thousandth of the image.
    """
    length = ray_length(stereo.to_depth(stereo.complete(disparity), scene.rig.fx), scene.rig)
    clear = scene.rgb.reshape(-1, 3) / 255.0
    brightest = np.argsort(clear.min(axis=1), kind="stable")[-max(1, len(clear) // 1000) :]
    airlight = clear[brightest].mean(axis=0)
    return [to_8_bit(_mixed(scene, beta * length, airlight)) for beta in betas]


def _mixed(scene: Scene, optical_depth: np.ndarray, airlight: np.ndarray) -> np.ndarray:
    transmittance = np.exp(-optical_depth)[:, :, None]
    return transmittance * (scene.rgb / 255.0) + (1 - transmittance) * airlight
