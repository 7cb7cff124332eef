"""Shards of Synscapes by depth that a simulated stereo camera measured: the depth, the fog, and the errors of both."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from foggy_synscapes.camera import Camera
from foggy_synscapes.datasets import synscapes
from foggy_synscapes.depth import quality, refinement
from foggy_synscapes.depth.simulation import Errors, completed
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.fog.models import MODELS
from foggy_synscapes.frames import rendering
from foggy_synscapes.frames.stereo import GUIDED, Refined
from foggy_synscapes.io.arrays import encode_npz, read_npz
from foggy_synscapes.io.images import encode_png, read_ids
from foggy_synscapes.io.shards import Shard
from foggy_synscapes.labels import CLASSES, to_train_ids

Light = tuple[int, int, int]
COLUMNS = ("class", "distance", *quality.SUMS)
HOMOGENEOUS = "homogeneous"


@dataclass(frozen=True)
class Indexed:
    """Frames of Synscapes whose files have to be as they were indexed: folder, SHA-256 by path, cameras by frame."""

    root: Path
    index: Mapping[str, str]
    cameras: Mapping[int, Camera]


def depth_name(frame: int) -> str:
    """Name of a frame's depth in a shard.

    >>> depth_name(12)
    '00012_depth.npz'
    """
    return f"{frame:05d}_depth.npz"


def depths(frames: Indexed, errors: Errors, seed: int, superpixels: int) -> Iterator[tuple[str, Callable[[], bytes]]]:
    """Name in a shard of each frame's completed depth, and what makes it; FoggyError where it cannot be completed."""

    def make(frame: int) -> bytes:
        clear = rendering.read_frame(frames.root, frame, frames.index)
        try:
            found = completed(clear.image, clear.depth, frames.cameras[frame], errors, (seed, frame), superpixels)
        except ValueError as error:
            raise FoggyError(f"{clear.depth_name}: {error}") from error
        return encode_npz("depth", found)

    return ((depth_name(frame), partial(make, frame)) for frame in frames.cameras)


def foggy(
    frames: Indexed, completed_depth: Shard, lights: Mapping[int, Light], beta: str, geometry: str, level: int
) -> Iterator[tuple[str, bytes, np.ndarray]]:
    """Each foggy image of completed depth: its name, its content, and its errors as `quality.sums` has them.

    The transmittance of completed depth is refined by the guided filter, as it is published.
    """
    for frame, camera in frames.cameras.items():
        clear, name = rendering.read_frame(frames.root, frame, frames.index), depth_name(frame)
        depth = read_npz(completed_depth.read(name), "depth", f"{completed_depth.path}#{name}")
        refined = Refined(clear.image, depth, camera, geometry, GUIDED, None)
        t = refined.transmittance(beta)
        image = refinement.composite(clear.image, t, lights[frame])
        rays = rendering.rays_of(clear, camera, f"frame {frame}", geometry)
        truth = MODELS[HOMOGENEOUS].images(clear.image, clear.depth, rays, lights[frame], [float(beta)])[0]
        exact = refinement.initial(clear.depth.astype(np.float64), rays, float(beta))
        label = synscapes.class_(frame)
        ids = to_train_ids(read_ids(rendering.read_indexed(frames.root, label, frames.index), label), label)
        sums = quality.sums(ids, (clear.depth, depth), (exact, t), (truth, image))
        yield synscapes.foggy_name(frame, beta), encode_png(image, max(level, 1)), sums


def rows(sums: np.ndarray) -> list[tuple[str | float, ...]]:
    """Lines of the table of errors: by class and distance, those that have a pixel."""
    names = (*CLASSES, "not labelled")
    return [
        (names[c], group, int(sums[c, d, 0]), *sums[c, d, 1:].tolist())
        for c in range(len(names))
        for d, group in enumerate(quality.GROUPS)
        if sums[c, d, 0]
    ]
