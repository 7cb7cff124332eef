"""One frame: draw a street, paint it, finish it as the domain's camera would."""

from dataclasses import dataclass

import numpy as np

from foggy_synscapes.standin import furniture, metadata, street, traffic
from foggy_synscapes.standin.camera import Rig, sample_rig
from foggy_synscapes.standin.canvas import FARTHEST, SKY_FAR, SKY_NEAR, STRIDE, Canvas
from foggy_synscapes.standin.style import ID, Style, colour, sample_weather, upsample

EGO = 1
"""labelId of the camera's own car: void in the evaluation."""

BRIGHTEST = "fbfff9"
"""The brightest sky of the published samples."""


@dataclass(frozen=True)
class Scene:
    """A rendered frame with its exact ground truth.

    rgb uint8 (H, W, 3); depth float32 (H, W), planar metres; label_ids uint8 (H, W), Cityscapes labelIds;
    instances uint32 (H, W), 0 where no road user is; rig, the camera; instance and scene, metadata as Synscapes has it.
    """

    rgb: np.ndarray
    depth: np.ndarray
    label_ids: np.ndarray
    instances: np.ndarray
    rig: Rig
    instance: dict[str, dict]
    scene: dict[str, float]

    def instance_ids(self) -> np.ndarray:
        """Cityscapes' instanceIds, uint16 (H, W): labelId * 1000 + n on road users, the labelId elsewhere."""
        numbered = self.instances // STRIDE * 1000 + self.instances % STRIDE
        return np.where(self.instances > 0, numbered, self.label_ids).astype(np.uint16)


def render(
    seed: tuple[int, ...],
    size: tuple[int, int],
    *,
    real: bool,
    blue: bool = False,
    overcast: bool = False,
    trains: bool = True,
    hood: bool = False,
) -> Scene:
    """Render a street scene.

    Parameters
    ----------
    seed : whole numbers that alone decide the frame, e.g. (seed, stream, frame)
    size : rows and columns
    real : richer texture, and a camera's noise and colours; else smooth surfaces
    blue : a cloudless blue sky under direct sun; else a bright veiled or clouded one
    overcast : flat white sky, as on a foggy day
    trains : whether trains may occur
    hood : whether one calibrated camera sees the front of its own car (labelId 1), as in Cityscapes

    >>> scene = render((1, 2, 3), (32, 64), real=False)
    >>> scene.rgb.shape, scene.depth.dtype.name, bool(np.isfinite(scene.depth).all())
    ((32, 64, 3), 'float32', True)
    """
    layout, pixels = (np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(2))
    style = Style(layout, 0.13 if real else 0.03, sample_weather(layout, blue, overcast))
    canvas = Canvas(sample_rig(layout, size, 0.1 if hood else 1.0), style)
    road = street.sample_street(layout, trains)
    users = traffic.place_vehicles(road, style)
    street.paint_ground(canvas, road)
    traffic.paint_shadows(canvas, users)
    built = street.paint_houses(canvas, road)
    furniture.paint_furniture(canvas, road)
    traffic.paint_vehicles(canvas, users)
    traffic.paint_people(canvas, road, users)
    _paint_sky(canvas)
    if hood:
        _paint_hood(canvas)
    return Scene(
        rgb=to_8_bit(_sensed(canvas.rgb, layout, pixels) if real else _softened(canvas.rgb, 0.15, 0.7)),
        depth=canvas.depth,
        label_ids=np.where(canvas.number < STRIDE, canvas.number, canvas.number // STRIDE).astype(np.uint8),
        instances=np.where(canvas.number < STRIDE, 0, canvas.number).astype(np.uint32),
        rig=canvas.rig,
        instance=metadata.describe_instances(canvas),
        scene=metadata.scene_values(canvas, road, users, built),
    )


def to_8_bit(rgb: np.ndarray) -> np.ndarray:
    """Colours in [0, 1], and what lies beyond, as uint8."""
    return np.clip(np.floor(rgb * 255 + 0.5), 0, 255).astype(np.uint8)


def _paint_sky(canvas: Canvas) -> None:
    # Every pixel that nothing else has covered.
    weather, rng = canvas.style.weather, canvas.style.rng
    sky = canvas.depth > FARTHEST
    up = np.clip(canvas.rays[1][sky], 0, 1)
    canvas.depth[sky] = (SKY_NEAR + 60) + (SKY_FAR - SKY_NEAR - 120) * np.minimum(1, 2.5 * up)
    canvas.number[sky] = ID["sky"]
    white = colour(BRIGHTEST)
    if weather.blue:
        canvas.rgb[sky] = _mixed(colour("accdf6"), colour("6092de"), np.minimum(1, up / 0.32))
        return
    overcast = weather.sky_contrast < 3.4
    rows, columns = (5, 7) if overcast else (8, 9)
    clouds = 0.7 * upsample(rng.standard_normal((rows, columns)), sky.shape)
    clouds += 0.3 * upsample(rng.standard_normal((3 * rows, 3 * columns)), sky.shape)
    clouds = clouds[sky].astype(np.float32)
    if overcast:  # grey swells in the white
        canvas.rgb[sky] = white * (1 - np.clip((clouds - 0.25) * 0.12 + 0.25 * up, 0, 0.16))[:, None]
        return
    # Blue gaps only well above the horizon: enough white is always seen for a white airlight.
    height = np.clip((up - 0.07) / 0.08, 0, 1)
    gap = np.clip((clouds - 0.3) * 1.8, 0, 0.9) * height * min(1.0, (weather.sky_contrast - 2.9) / 1.6)
    canvas.rgb[sky] = _mixed(white, colour("8ebae4"), gap)


def _mixed(low: np.ndarray, high: np.ndarray, part: np.ndarray) -> np.ndarray:
    return low * (1 - part[:, None]) + high * part[:, None]


def _paint_hood(canvas: Canvas) -> None:
    rows, columns = canvas.depth.shape
    down = (np.arange(rows) + 0.5)[:, None] / rows
    across = ((np.arange(columns) + 0.5) / columns - 0.5)[None, :]
    hood = down > 0.925 + 0.35 * across**2
    canvas.rgb[hood] = (0.16 + 0.9 * (down - 0.92)).repeat(columns, axis=1)[hood][:, None].astype(np.float32)
    canvas.depth[hood], canvas.number[hood] = 1.8, EGO


def _softened(rgb: np.ndarray, side: float, middle: float) -> np.ndarray:
    # The softness of a lens: the weights of a pixel and of its neighbours on each side.
    rgb = np.minimum(rgb, 1.0)
    edge = np.pad(rgb, ((1, 1), (0, 0), (0, 0)), mode="edge")
    rgb = side * (edge[:-2] + edge[2:]) + middle * rgb
    edge = np.pad(rgb, ((0, 0), (1, 1), (0, 0)), mode="edge")
    return side * (edge[:, :-2] + edge[:, 2:]) + middle * rgb


def _sensed(rgb: np.ndarray, layout: np.random.Generator, pixels: np.random.Generator) -> np.ndarray:
    # What a real camera adds: softness, tint, exposure, vignetting, and the noise of its sensor.
    rgb = _softened(rgb, 0.25, 0.5)
    rows, columns, _ = rgb.shape
    gain = np.array([0.93, 1.0, 0.95], np.float32) * layout.uniform(0.95, 1.05, 3).astype(np.float32)
    exposure = np.float32(layout.uniform(0.88, 1.08))
    y = np.linspace(-1, 1, rows, dtype=np.float32)[:, None, None]
    x = np.linspace(-1, 1, columns, dtype=np.float32)[None, :, None]
    rgb = 0.03 + 0.94 * (rgb * gain * exposure * (1 - 0.09 * (x * x + y * y)))
    blotches = upsample(pixels.standard_normal((rows // 3 + 2, columns // 3 + 2)), (rows, columns)).astype(np.float32)
    noise = pixels.standard_normal(rgb.shape, dtype=np.float32)
    return rgb * (1 + np.float32(0.015) * blotches[:, :, None]) + np.float32(0.013) * noise
