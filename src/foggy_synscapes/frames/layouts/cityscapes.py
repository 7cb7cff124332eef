"""Cityscapes: fog and depth from stereo, in the folders and under the names of Foggy Cityscapes."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from foggy_synscapes.datasets import cityscapes, foggy_cityscapes
from foggy_synscapes.depth.completion import SEED
from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.frames import rendering, stereo
from foggy_synscapes.frames.finding import Frame
from foggy_synscapes.frames.folders import Done, Job, Make, read_input, take_airlight, write
from foggy_synscapes.frames.layouts.layout import Layout, Request
from foggy_synscapes.frames.stereo_shards import depth_name, members
from foggy_synscapes.io.arrays import encode_npz
from foggy_synscapes.io.hashing import sha256_bytes
from foggy_synscapes.io.images import encode_png

STEREO, HOMOGENEOUS = "stereo", "homogeneous"
DEPTH = "depth"


@dataclass(frozen=True)
class StereoFrame(Frame):
    """A frame, `id` as split, city and stem; `rgb` is the left image and `depth` the disparity."""

    right: Path = Path()
    ids: Path | None = None

    def files(self) -> tuple[Path, ...]:
        """All files that it is made of: left, right, disparity, camera, and instance ids where they are wanted."""
        return (self.rgb, self.right, self.depth, self.camera, *([self.ids] if self.ids else []))


@dataclass(frozen=True)
class StereoJob(Job):
    """What to make of each stereo frame: foggy images, maps of their transmittance, and completed depth.

    refine : one of `stereo.REFINEMENTS`; seed : of the random permutations
    images, depth : whether foggy images and depth are written
    """

    refine: str = stereo.GUIDED
    seed: int = SEED
    images: bool = True
    depth: bool = False

    made = "*/*/*/[!.]*"

    def paths(self, frame: Frame) -> tuple[list[Path], list[Path]]:
        """Foggy images, and all else that is made of a frame."""
        targets = self._targets(frame)
        images = [path for path, (kind, _) in targets.items() if kind == stereo.FOGGY]
        return images, [path for path, (kind, _) in targets.items() if kind != stereo.FOGGY]

    def _targets(self, frame: Frame) -> dict[Path, tuple[str, str]]:
        """Kind and beta by path of all that is made of a frame; folders and names as they are published."""
        kinds = ([stereo.FOGGY] if self.images else []) + ([stereo.TRANSMITTANCE] if self.transmittance else [])
        found = {self.out / "depth" / depth_name(frame.id): (DEPTH, "")} if self.depth else {}
        for kind in kinds:
            for beta in self.betas:
                found[self.out / stereo.published(kind, self.refine, frame.id, beta)] = kind, beta
        return found

    def settings(self) -> dict[str, Any]:
        """What else decides the pixels."""
        return {**super().settings(), "depth_from": STEREO, "refine": self.refine, "seed": self.seed}

    def open(self, frame: Frame) -> tuple[str, Make]:
        """Read a frame's files; what makes it raises FoggyError as `stereo.read_views` and `stereo.completed` do."""
        contents = [read_input(frame, path, number) for number, path in enumerate(frame.files())]
        sources = [stereo.Source(data, str(path)) for data, path in zip(contents, frame.files(), strict=True)]
        of = sha256_bytes(json.dumps([sha256_bytes(data) for data in contents]).encode())
        return of, partial(self._make, frame, sources)

    def _make(self, frame: Frame, sources: list[stereo.Source], wanted: set[Path], done: Done) -> None:
        left, right, disparity, camera, *ids = sources
        views = stereo.read_views(left, right, disparity, camera)
        light = take_airlight(views.left, self, done)
        if done.blue and self.treatment == rendering.DROP:
            return
        depth, done.warnings = stereo.completed(views, self.seed)
        targets = {path: target for path, target in self._targets(frame).items() if path in wanted}
        write(self, self._encoded(targets, views, depth, light.levels, ids[0] if ids else None), done)

    def _encoded(
        self,
        targets: dict[Path, tuple[str, str]],
        views: stereo.Views,
        depth: np.ndarray,
        light: tuple[int, int, int],
        ids: stereo.Source | None,
    ) -> Iterator[tuple[Path, bytes]]:
        yield from ((path, encode_npz("depth", depth)) for path, (kind, _) in targets.items() if kind == DEPTH)
        betas = list(dict.fromkeys(beta for kind, beta in targets.values() if kind != DEPTH))
        if not betas:
            return
        refined = stereo.Refined(views.left, depth, views.stereo.camera, self.geometry, self.refine, ids)
        for beta, (image, levels) in zip(betas, refined.foggy(betas, light), strict=True):
            for path, (kind, own) in targets.items():
                if own == beta and kind != DEPTH:
                    yield path, encode_png(image if kind == stereo.FOGGY else levels, max(self.level, 1))


def fog(request: Request, job: Job) -> tuple[list[Frame], Job]:
    """Foggy images of frames with fog from stereo."""
    if job.model != HOMOGENEOUS:
        raise UsageError(f"--model {job.model}: transmittance is refined of {HOMOGENEOUS} fog only")
    refine = _refinement(request)
    return _frames(request, refine), StereoJob(**vars(job), refine=refine, seed=_seed(request))


def complete(request: Request, job: Job) -> tuple[list[Frame], Job]:
    """Completed depth of frames, and transmittance where there are betas."""
    refine = _refinement(request)
    settings = {**vars(job), "transmittance": bool(job.betas)}
    made = StereoJob(**settings, refine=refine, seed=_seed(request), images=False, depth=True)
    return _frames(request, refine if job.betas else stereo.GUIDED), made


def _refinement(request: Request) -> str:
    if request.depth_from not in (None, STEREO):
        raise UsageError(f"--depth-from {request.depth_from}: Cityscapes has depth from {STEREO} only")
    if request.refine is not None and request.refine not in stereo.REFINEMENTS:
        raise UsageError(f"--refine {request.refine}: expected {' or '.join(stereo.REFINEMENTS)}")
    return request.refine or stereo.GUIDED


def _seed(request: Request) -> int:
    seed = SEED if request.seed is None else request.seed
    if not 0 <= seed < 2**32:
        raise UsageError(f"--seed {seed}: expected a whole number from 0 to 2^32 - 1")
    return seed


def _frames(request: Request, refine: str) -> list[Frame]:
    """Frames of the splits, sorted, or those that a list names."""
    images = request.root / "leftImg8bit"
    if not images.is_dir():
        raise UsageError(f"{images}: no such folder; --root names the folder that holds leftImg8bit, disparity, ...")
    there = sorted(path.name for path in images.iterdir() if path.is_dir())
    for split in request.splits:
        if split not in there:
            raise UsageError(f"{images}: no split {split}; there are {', '.join(there) or 'none'}")
    splits = request.splits or there
    if request.listed is not None:
        listed = foggy_cityscapes.read_refined(request.listed.parent, request.listed.name)
        names = [name for split, found in listed.items() if split in splits for name in found]
    else:
        files = [path.relative_to(request.root).as_posix() for path in images.glob("*/*/*_leftImg8bit.png")]
        names = [name for split in splits for name in cityscapes.frames(files, split)]
    if not names:
        raise FoggyError(f"{request.listed or images}: no frame SPLIT/CITY/NAME_leftImg8bit.png of {', '.join(splits)}")
    root = request.root
    return [
        StereoFrame(
            id=name,
            rgb=root / cityscapes.image(name),
            depth=root / cityscapes.disparity(name),
            camera=root / cityscapes.camera(name),
            right=root / cityscapes.right(name),
            ids=root / cityscapes.instances(name) if refine == stereo.BILATERAL else None,
        )
        for name in names
    ]


LAYOUT = Layout(
    text="depth completed from stereo",
    fog=fog,
    complete=complete,
    members=members,
    takes=("split", "list", "depth_from", "refine", "seed"),
)
