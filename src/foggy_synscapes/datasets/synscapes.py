"""Synscapes on disk: `img/{rgb,class,instance}/N.png`, `img/depth/N.exr`, `meta/N.json`, N from 1, unpadded.

Source: Wrenninge and Unger, Synscapes: A Photorealistic Synthetic Dataset for Street Scene Parsing, 2018.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from foggy_synscapes.camera import Camera
from foggy_synscapes.datasets.dataset import STAND_IN, Dataset, Incomplete
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.files import LARGEST_JSON, named, number, parse_json, read_bytes

SCENE_KEYS = (
    "altitude_variation", "curb_height", "dist_bicyclists_mean", "dist_bicyclists_stddev", "dist_buses_mean",
    "dist_buses_stddev", "dist_cars_mean", "dist_cars_stddev", "dist_motorcyclists_mean", "dist_motorcyclists_stddev",
    "dist_pedestrians_mean", "dist_pedestrians_stddev", "dist_trains_mean", "dist_trains_stddev", "dist_trucks_mean",
    "dist_trucks_stddev", "ego_speed", "fence_height", "fence_presence", "median_presence", "num_bicyclists",
    "num_buses", "num_cars", "num_motorcyclists", "num_pedestrians", "num_trains", "num_trucks", "parking_angle",
    "parking_presence", "rel_dist_to_isect", "sidewalk_width", "sky_contrast", "sun_height", "wall_height",
    "wall_presence",
)  # fmt: skip
"""The scene properties of a meta file."""

# Paths below the root, by the number of a frame: clear image, planar depth in metres, labelIds, instance ids
# (R + 256 G + 65536 B) and meta file.
rgb, depth, class_ = "img/rgb/{}.png".format, "img/depth/{}.exr".format, "img/class/{}.png".format
instance, meta = "img/instance/{}.png".format, "meta/{}.json".format

LARGEST_VALUE = 1e300


@dataclass(frozen=True)
class Meta:
    """A frame's meta file: camera, scene keys, instances (as they stand in the file)."""

    camera: Camera
    scene: dict[str, float]
    instances: dict[str, Any]


def foggy_name(frame: int, beta: str) -> str:
    """File name of a foggy image, as the published script spells it.

    >>> foggy_name(1, "0.005")
    '00001_beta_0.005.png'
    """
    return f"{frame:05d}_beta_{beta}.png"


def shard_frames(shard: str, size: int, last: int | None = None) -> range:
    """Ids of the frames in a shard: 0000 holds 1 to size, 0001 the next, up to the dataset's last id."""
    first = int(shard) * size + 1
    end = first + size
    return range(first, end if last is None else min(end, last + 1))


def camera_of(row: Mapping[str, str]) -> Camera:
    """Camera from a row of `kept.csv`: its columns fx, fy, u0, v0, resx and resy."""
    fx, fy, u0, v0 = (float(row[name]) for name in ("fx", "fy", "u0", "v0"))
    return Camera(fx, fy, u0, v0, int(row["resx"]), int(row["resy"]))


def read_camera(path: str | Path) -> Camera:
    """Read the camera of a meta file or of a file that holds nothing else."""
    return _camera(_read(path), path)


def read_meta(path: str | Path, check: Callable[[bytes], bytes] = bytes) -> Meta:
    """Read a meta file. Truth values are 0 and 1; what is missing, null or infinite is NaN; further keys do not count.

    `check` is given the file's bytes and returns them, or raises where they are not the expected ones.

    Raises FoggyError if it is no meta file, or a scene key has a word or a list for its value.
    """
    document = _read(path, check)
    scene = document.get("scene")
    if not isinstance(scene, dict):
        raise FoggyError(f"{path}: no section `scene`; is this a Synscapes meta file?")
    values: dict[str, float] = {}
    for key in SCENE_KEYS:
        value = scene.get(key)
        if not isinstance(value, int | float | None):
            raise FoggyError(f"{path}: scene key {key} is {value!r}, expected a number")
        value = int(value) if isinstance(value, bool) else value
        values[key] = math.nan if value is None or not abs(value) < LARGEST_VALUE else value
    return Meta(_camera(document, path), values, document.get("instance", {}))


def _read(path: str | Path, check: Callable[[bytes], bytes] = bytes) -> dict[str, Any]:
    advice = "Every frame needs its meta file (or give one camera for all)."
    document = parse_json(check(read_bytes(path, "JSON file", advice, LARGEST_JSON)), path)
    if not isinstance(document, dict):
        raise FoggyError(f"{path}: expected an object with `camera`, got {type(document).__name__}")
    return document


def _camera(document: dict[str, Any], path: str | Path) -> Camera:
    intrinsic = document.get("camera", {}).get("intrinsic", {}) if isinstance(document.get("camera"), dict) else {}
    found: dict[str, Any] = {}
    for name in ("fx", "fy", "u0", "v0", "resx", "resy"):
        if not isinstance(intrinsic, dict) or name not in intrinsic:
            raise FoggyError(f"{path}: camera.intrinsic.{name} missing")
        with named(f"{path}: camera.intrinsic.{name}", "number"):
            found[name] = number(intrinsic[name])
    with named(f"{path}: camera.intrinsic", "camera"):
        camera = Camera(**found)
        return replace(camera, resx=int(camera.resx), resy=int(camera.resy))


def files(root: Path, scenes: Any, shard: str) -> list[str]:
    """Image, depth, class and meta of each frame of a shard; FoggyError naming what a frame lacks."""
    # Of the stand-in the last shard may be short; a real frame that is not there must not pass for that.
    last = scenes.stand_in.synscapes if scenes.roots["synscapes"] == STAND_IN else None
    ids, paths = shard_frames(shard, scenes.shard_frames, last), []
    for frame in ids:
        own = [name(frame) for name in (rgb, depth, class_, meta)]
        missing = [path for path in own if not (root / path).is_file()]
        if missing:
            raise Incomplete(
                f"{root}: frame {frame} lacks {', '.join(missing)}. Frames {ids[0]} to {ids[-1]} need image, depth, "
                "class and meta; see scenes.shards and scenes.shard_frames.",
                missing[0],
            )
        paths += own
    return paths


DATASET = Dataset(
    title="Synscapes",
    short_title="Synscapes",
    files=files,
    parts="scenes.shards",
    settings=("scenes.shard_frames", "scenes.shards"),
    pixels=1440 * 720,
    folders=("img/rgb", "img/depth", "img/class", "meta"),
    home="7dlabs.com/synscapes",
)
