"""One frame: draw a street, paint it, finish it as the domain's camera would."""

from dataclasses import dataclass

import numpy as np

from foggy_synscapes.standin import furniture, sky, street, traffic
from foggy_synscapes.standin.camera import Rig, sample_rig
from foggy_synscapes.standin.canvas import Canvas
from foggy_synscapes.standin.metadata import describe_instances, scene_values
from foggy_synscapes.standin.noise import upsample

DOMAINS = ("synthetic", "real")


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


def render(
    seed: tuple[int, ...],
    size: tuple[int, int],
    domain: str,
    *,
    blue: bool = False,
    overcast: bool = False,
    trains: bool = True,
    hood: bool = False,
    spread: float = 1.0,
) -> Scene:
    """Render a street scene.

    Parameters
    ----------
    seed : whole numbers that alone decide the frame, e.g. (seed, stream, frame)
    size : rows and columns
    domain : "synthetic" (smooth surfaces) or "real" (richer texture, a camera's noise and colours)
    blue : a cloudless blue sky under direct sun; else a bright veiled or clouded one
    overcast : flat white sky, as on a foggy day
    trains : whether trains may occur
    hood : whether the camera sees the front of its own car (labelId 1), as in Cityscapes
    spread : how much the camera varies, see `sample_rig`

    Raises
    ------
    ValueError
        If the domain is unknown or the size below 16 x 16.

    >>> scene = render((1, 2, 3), (32, 64), "synthetic")
    >>> scene.rgb.shape, scene.depth.dtype.name, bool(np.isfinite(scene.depth).all())
    ((32, 64, 3), 'float32', True)
    """
    if domain not in DOMAINS:
        raise ValueError(f"domain: {domain!r} is none of {DOMAINS}")
    if min(size) < 16:
        raise ValueError(f"size: {size} is below 16 x 16 pixels")
    layout, pixels = (np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(2))
    grain = 0.03 if domain == "synthetic" else 0.13
    weather = sky.sample_weather(layout, blue, overcast)
    rig = sample_rig(layout, size, spread)
    road = street.sample_street(layout, trains)
    users = traffic.Traffic()
    placed = traffic.place_vehicles(road, layout, weather, grain, users)
    canvas = Canvas(rig, weather.sun, weather.ambient, weather.direct)
    street.paint_ground(canvas, road, layout, grain)
    traffic.paint_shadows(canvas, placed, weather)
    built = street.paint_houses(canvas, road, layout, weather, grain)
    furniture.paint_furniture(canvas, road, layout, weather, grain)
    traffic.paint_vehicles(canvas, placed, users)
    traffic.paint_people(canvas, road, layout, users)
    sky.paint_sky(canvas, weather, layout, street.ID["sky"])
    if hood:
        _paint_hood(canvas)
    shape = size
    instances = canvas.instance.reshape(shape)
    return Scene(
        rgb=_finish(canvas.rgb.reshape(*shape, 3), domain, weather.blue, layout, pixels),
        depth=canvas.depth.reshape(shape),
        label_ids=canvas.label.reshape(shape),
        instances=instances,
        rig=rig,
        instance=describe_instances(canvas, rig),
        scene=scene_values(canvas, road, users, weather, built, layout),
    )


def _paint_hood(canvas: Canvas) -> None:
    rows = (np.arange(canvas.rows) + 0.5)[:, None] / canvas.rows
    columns = ((np.arange(canvas.columns) + 0.5) / canvas.columns - 0.5)[None, :]
    hood = (rows > 0.925 + 0.35 * columns**2).ravel()
    tone = (0.16 + 0.9 * (rows - 0.92) + 0.0 * columns).ravel()[hood]
    canvas.rgb[hood] = tone[:, None].astype(np.float32)
    canvas.depth[hood], canvas.label[hood], canvas.instance[hood] = np.float32(1.8), street.EGO, 0


def _finish(
    rgb: np.ndarray, domain: str, blue: bool, layout: np.random.Generator, pixels: np.random.Generator
) -> np.ndarray:
    # Lens softness on both; the real domain adds tone, tint, vignetting and noise of a sensor.
    rgb = np.minimum(rgb, 1.0)
    edge = np.pad(rgb, ((1, 1), (0, 0), (0, 0)), mode="edge")
    rgb = 0.25 * (edge[:-2] + edge[2:]) + 0.5 * rgb if domain == "real" else 0.15 * (edge[:-2] + edge[2:]) + 0.7 * rgb
    edge = np.pad(rgb, ((0, 0), (1, 1), (0, 0)), mode="edge")
    rgb = (
        0.25 * (edge[:, :-2] + edge[:, 2:]) + 0.5 * rgb
        if domain == "real"
        else 0.15 * (edge[:, :-2] + edge[:, 2:]) + 0.7 * rgb
    )
    if domain == "real":
        rows, columns = rgb.shape[:2]
        gain = np.array([0.93, 1.0, 0.95], np.float32) * layout.uniform(0.95, 1.05, 3).astype(np.float32)
        exposure = np.float32(layout.uniform(0.88, 1.08))
        y, x = (
            np.linspace(-1, 1, rows, dtype=np.float32)[:, None, None],
            np.linspace(-1, 1, columns, dtype=np.float32)[None, :, None],
        )
        rgb = rgb * gain * exposure * (1 - 0.09 * (x * x + y * y))
        rgb = 0.03 + 0.94 * rgb
        blotches = upsample(pixels.standard_normal((rows // 3 + 2, columns // 3 + 2)), (rows, columns)).astype(
            np.float32
        )
        noise = pixels.standard_normal(rgb.shape, dtype=np.float32)
        rgb = rgb * (1 + np.float32(0.015) * blotches[:, :, None]) + np.float32(0.013) * noise
    return np.clip(np.floor(rgb * 255 + 0.5), 0, 255).astype(np.uint8)
