"""The reference: light through fog by volumetric path tracing (Mitsuba 3, of the extra `reference`).

All that the scene does not model is taken to shine with the surround's radiance E, and transport is linear, so
    F = E + t (R - E) + S,   S = P[R - E]
with P the light of the surfaces that arrives after at least one scattering. The surfaces therefore emit R - E, and
nothing else shines: what leaves the scene adds nothing, the size of the fog does not matter, and S, all that is
rendered, is the error of Koschmieder's law. Where the air absorbs (albedo below 1), E is what it replaces.

Surfaces are black to the light of fog, since R already holds the light that fell on them when the air was clear.
"""

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from foggy_synscapes.atlas.cells import Cell
from foggy_synscapes.atlas.scenes import Scene
from foggy_synscapes.errors import FoggyError

VARIANT = "scalar_rgb"
"""Of Mitsuba: it needs no LLVM, and its random numbers do not depend on the processor."""
RADIUS = 10.0
"""Optical depths from the camera to where the fog ends."""
BELOW = 1.05
"""Times the camera's height: how far below it the plane of the road lies, so that the frame's own road hides it."""
PLANE = 3000.0  # metres, half of its side
NO_ROULETTE = 1_000_000
"""Scatterings before paths are ended by chance: Russian roulette ends one in twenty even where nothing is absorbed."""
LAYERS, TOP = 512, 8.0
"""Steps of height by which fog that thins with height is tabulated, up to so many scale heights."""


def mitsuba() -> Any:
    """The library, set up; FoggyError where it is not installed."""
    try:
        import mitsuba as library
    except ImportError as error:
        raise FoggyError(
            f"rendering the reference needs Mitsuba 3 ({error}). "
            "Install the extra: pip install foggy-synscapes[reference]"
        ) from error
    library.set_variant(VARIANT)
    library.set_log_level(library.LogLevel.Error)  # it warns of each sample of negative radiance, which is meant here
    return library


def scattered(scene: Scene, cell: Cell, samples: int, seed: int, threads: int = 1) -> np.ndarray:
    """The part S of a scene's light in fog, linear radiance, float64 (H, W, 3).

    samples : paths per pixel; seed : of their random numbers, which alone decide the result

    Raises FoggyError where Mitsuba is not installed.
    """
    from foggy_synscapes.fog.radiance import linear

    library = mitsuba()
    import drjit

    drjit.set_thread_count(threads)
    beyond = scene.surround(cell.surround)
    ground = scene.ground(cell.surround)
    with tempfile.TemporaryDirectory() as folder:
        shapes: dict[str, Any] = {"relief": _relief(Path(folder), scene, linear(scene.image) - beyond)}
        if ground is not None:
            shapes["ground"] = _plane(scene, ground - beyond)
        loaded = library.load_dict(_world(scene, cell, shapes))
        image = library.render(loaded, spp=samples, seed=seed)
    return np.array(image, dtype=np.float64)[..., :3]


def _world(scene: Scene, cell: Cell, shapes: dict[str, Any]) -> dict[str, Any]:
    from mitsuba import ScalarTransform4f as Transform

    camera = scene.camera
    fog = {"type": "ref", "id": "fog"}
    return {
        "type": "scene",
        "integrator": {"type": "volpath", "max_depth": -1, "rr_depth": NO_ROULETTE, "hide_emitters": True},
        "fog": _medium(scene, cell),
        "sensor": {
            "type": "perspective",
            "fov": float(np.degrees(2 * np.arctan(camera.resx / 2 / camera.fx))),
            "fov_axis": "x",
            "near_clip": 1e-3,
            "far_clip": 1e6,
            "to_world": Transform().look_at(origin=[0, 0, 0], target=[0, 0, 1], up=[0, 1, 0]),
            "medium": fog,
            "film": {
                "type": "hdrfilm",
                "width": int(camera.resx),
                "height": int(camera.resy),
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
                "component_format": "float32",
            },
            "sampler": {"type": "independent"},
        },
        "edge": {"type": "sphere", "radius": RADIUS / cell.beta, "bsdf": {"type": "null"}, "interior": fog},
        **{name: {**shape, "interior": fog, "exterior": fog} for name, shape in shapes.items()},
    }


def _medium(scene: Scene, cell: Cell) -> dict[str, Any]:
    phase = {"type": "hg", "g": cell.asymmetry} if cell.asymmetry else {"type": "isotropic"}
    common = {"albedo": {"type": "rgb", "value": [cell.albedo] * 3}, "phase": phase, "sample_emitters": False}
    if not cell.height:
        # The extinction as a colour may not be above 1, so beta is its scale.
        return {"type": "homogeneous", "sigma_t": {"type": "rgb", "value": [1.0] * 3}, "scale": cell.beta, **common}
    return {"type": "heterogeneous", "sigma_t": _layers(scene, cell), "scale": cell.beta, **common}


def _layers(scene: Scene, cell: Cell) -> dict[str, Any]:
    """Extinction relative to that at the road: constant below it, an exponential above."""
    import mitsuba
    from mitsuba import ScalarTransform4f as Transform

    depth, top = scene.height * 2, TOP * cell.height
    step = (depth + top) / LAYERS
    heights = (np.arange(LAYERS) + 0.5) * step - depth  # above the road, of the cells' middles
    values = np.exp(-np.maximum(heights, 0) / cell.height).astype(np.float32)
    # A volume is given by planes; its third axis is turned upright, against the camera's pitch.
    side = 2 * RADIUS / cell.beta
    grid = mitsuba.VolumeGrid(np.ascontiguousarray(np.broadcast_to(values[:, None, None, None], (LAYERS, 2, 2, 1))))
    place = (
        Transform()
        .rotate([1, 0, 0], -float(np.degrees(scene.pitch)))
        .translate([-side / 2, -scene.height - depth, side / 2])
        .rotate([1, 0, 0], -90)
        .scale([side, side, depth + top])
    )
    return {"type": "gridvolume", "grid": grid, "to_world": place, "filter_type": "trilinear", "wrap_mode": "clamp"}


def _relief(folder: Path, scene: Scene, radiance: np.ndarray) -> dict[str, Any]:
    """The frame as a surface: its corners between pixels, each at the nearest of the depths around it."""
    import mitsuba

    height, width = scene.depth.shape
    padded = np.pad(scene.depth, 1, mode="edge")
    near = np.minimum.reduce([padded[:-1, :-1], padded[1:, :-1], padded[:-1, 1:], padded[1:, 1:]]).astype(np.float64)
    across = (np.arange(width + 1) - scene.camera.u0) / scene.camera.fx
    down = (np.arange(height + 1) - scene.camera.v0) / scene.camera.fy
    # Seen along z with y up, x runs to the left.
    points = np.stack([-across[None, :] * near, -down[:, None] * near, near], axis=-1).reshape(-1, 3)
    u, v = np.meshgrid(np.linspace(0, 1, width + 1), np.linspace(0, 1, height + 1))
    corner = np.arange((height + 1) * (width + 1)).reshape(height + 1, width + 1)
    a, b, c, d = (each.ravel() for each in (corner[:-1, :-1], corner[:-1, 1:], corner[1:, :-1], corner[1:, 1:]))
    faces = np.concatenate([np.stack([a, c, b], axis=1), np.stack([b, c, d], axis=1)])
    mesh = mitsuba.Mesh("relief", len(points), len(faces), has_vertex_texcoords=True)
    values = mitsuba.traverse(mesh)
    values["vertex_positions"] = points.astype(np.float32).ravel()
    values["vertex_texcoords"] = np.stack([u.ravel(), v.ravel()], axis=1).astype(np.float32).ravel()
    values["faces"] = faces.astype(np.uint32).ravel()
    values.update()
    file = folder / "relief.ply"
    mesh.write_ply(str(file))
    bitmap = mitsuba.Bitmap(np.ascontiguousarray(radiance, dtype=np.float32))
    texture = {"type": "bitmap", "bitmap": bitmap, "raw": True, "filter_type": "nearest", "wrap_mode": "clamp"}
    return {
        "type": "ply",
        "filename": str(file),
        "face_normals": True,
        "bsdf": _black(),
        "emitter": {"type": "area", "radiance": texture},
    }


def _plane(scene: Scene, radiance: np.ndarray) -> dict[str, Any]:
    from mitsuba import ScalarTransform4f as Transform

    place = (
        Transform()
        .rotate([1, 0, 0], -float(np.degrees(scene.pitch)))
        .translate([0, -BELOW * scene.height, 0])
        .rotate([1, 0, 0], -90)
        .scale([PLANE, PLANE, 1])
    )
    colour = {"type": "rgb", "value": [float(value) for value in radiance]}
    return {"type": "rectangle", "to_world": place, "bsdf": _black(), "emitter": {"type": "area", "radiance": colour}}


def _black() -> dict[str, Any]:
    return {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.0] * 3}}
