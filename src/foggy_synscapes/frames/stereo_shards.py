"""Members of shards of Cityscapes' stereo frames: their depth, and the foggy images that are made of it."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from foggy_synscapes.datasets import cityscapes
from foggy_synscapes.datasets.index import expect
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.frames import stereo
from foggy_synscapes.frames.layouts.layout import Member, Wanted
from foggy_synscapes.io.arrays import encode_npz, read_npz
from foggy_synscapes.io.hashing import read_checked
from foggy_synscapes.io.images import encode_png, read_rgb
from foggy_synscapes.io.shards import Shard

DATASET = "cityscapes_stereo"


@dataclass(frozen=True)
class Indexed:
    """Stereo frames whose files have to be as they were indexed.

    root : folder of the dataset; index : SHA-256 by path
    """

    root: Path
    index: Mapping[str, str]

    def source(self, path: str) -> stereo.Source:
        """A file's bytes, checked."""
        expect(self.index, [path], DATASET)
        return stereo.Source(read_checked(self.root / path, self.index[path]), str(self.root / path))

    def frames(self, shard: str, shards: list[str], size: int) -> list[str]:
        """Frames of a shard, sorted; FoggyError where the frames do not fill the shards, or not all of them."""
        every = sorted(name for split in ("train", "val") for name in cityscapes.frames(self.index, split))
        needed = -(-len(every) // size)
        if needed != len(shards):
            raise FoggyError(
                f"complete.shards: {len(every)} frames in shards of {size} are {needed} shards, got {len(shards)}"
            )
        first = int(shard) * size
        return every[first : first + size]

    def views(self, frame: str) -> stereo.Views:
        """What the stereo camera saw."""
        kinds = (cityscapes.image, cityscapes.right, cityscapes.disparity, cityscapes.camera)
        left, right, disparity, camera = (self.source(kind(frame)) for kind in kinds)
        return stereo.read_views(left, right, disparity, camera)


def depth_name(frame: str) -> str:
    """Name of a frame's completed depth in a shard, and below `depth` where it is written to folders."""
    return f"{frame}_depth.npz"


def depth(views: stereo.Views, seed: int, superpixels: int) -> tuple[bytes, list[str]]:
    """Completed depth of a frame as a file, and warnings."""
    found, warnings = stereo.completed(views, seed, superpixels)
    return encode_npz("depth", found), warnings


def members(wanted: Wanted) -> Iterator[Member]:
    """Foggy images of the frames that have an airlight, in the order of their names."""
    frames = Indexed(wanted.root, wanted.index)
    with Shard(wanted.completed) as completed:
        for frame in sorted(wanted.lights):
            name = stereo.published(stereo.FOGGY, wanted.refine, frame, wanted.beta)
            yield name, partial(_image, wanted, frames, completed, frame)


def _image(wanted: Wanted, frames: Indexed, completed: Shard, frame: str) -> bytes:
    depth_file, left = depth_name(frame), frames.source(cityscapes.image(frame))
    found = read_npz(completed.read(depth_file), "depth", f"{completed.path}#{depth_file}")
    image = read_rgb(left.file, left.name)
    camera = stereo.read_stereo(frames.source(cityscapes.camera(frame)), image.shape[1], image.shape[0]).camera
    ids = frames.source(cityscapes.instances(frame)) if wanted.refine == stereo.BILATERAL else None
    refined = stereo.Refined(image, found, camera, wanted.geometry, wanted.refine, ids)
    ((pixels, _),) = refined.foggy([wanted.beta], wanted.lights[frame])
    return encode_png(pixels, max(wanted.level, 1))
