"""Fog on folders of frames, without a pipeline: many processes, what is finished is kept, the broken are named."""

import json
import os
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from foggy_synscapes.camera import Camera
from foggy_synscapes.errors import UNFORESEEN, FoggyError
from foggy_synscapes.fog.airlight import Airlight
from foggy_synscapes.fog.geometry import Rays
from foggy_synscapes.frames import rendering, settings
from foggy_synscapes.frames.finding import Frame
from foggy_synscapes.io.atomic import write_bytes
from foggy_synscapes.io.files import read_bytes
from foggy_synscapes.io.hashing import sha256, sha256_bytes
from foggy_synscapes.io.images import SIGNATURE
from foggy_synscapes.io.processes import in_processes

Light = tuple[int, int, int, int, int]
"""Row of the airlight table without its id: red, green, blue, row, column."""

WRITERS = 8


@dataclass(frozen=True)
class Job:
    """What to make of each frame; `betas` as text in 1/m, `level` the deflate effort, `model` of fog.

    stated : the settings that the folder states from its first image on, see `frames.settings`
    """

    out: Path
    betas: list[str]
    geometry: str
    transmittance: bool
    level: int
    treatment: str
    model: str = "homogeneous"
    stated: str = ""

    made: ClassVar[str] = "beta_*/*/[!.]*"  # what images below `out` are called

    def name(self, path: Path) -> str:
        """What an image is called in the folder."""
        return path.relative_to(self.out).as_posix()

    def paths(self, frame: Frame) -> tuple[list[Path], list[Path]]:
        """Foggy images and transmittance maps of a frame, one per beta."""
        foggy = [self.out / f"beta_{beta}" / "foggy_img" / frame.name(beta) for beta in self.betas]
        maps = [self.out / f"beta_{beta}" / "transmittance" / frame.name(beta) for beta in self.betas]
        return foggy, maps if self.transmittance else []

    def settings(self) -> dict[str, Any]:
        """What decides the pixels, beside the frames and the code: equal for all images in one folder."""
        return {
            "geometry": self.geometry,
            "model": self.model,
            "blue_airlight": self.treatment,
            "png_level": self.level,
        }

    def foggy_files(self, clear: rendering.Clear, rays: Rays, light: Airlight, betas: Sequence[str]) -> Iterator[bytes]:
        """Foggy images as files, one per beta."""
        return rendering.foggy_pngs(self.model, clear, rays, light, list(betas), self.level)

    def open(self, frame: Frame) -> tuple[str, "Make"]:
        """Read a frame's files: what tells them from all others, and what makes the wanted ones of its `paths`."""
        rgb, depth = (read_input(frame, path, number) for number, path in enumerate((frame.rgb, frame.depth)))
        if frame.checksums:
            read_input(frame, frame.camera, 2)
        camera = rendering.read_camera(frame.camera)
        about = sha256_bytes(rgb), sha256_bytes(depth), vars(camera)
        return sha256_bytes(json.dumps(about).encode()), partial(_make, frame, self, rgb, depth, camera)


@dataclass(frozen=True)
class Made:
    """What is known of a frame that was fogged: what it was made of, its airlight, and SHA-256 by image.

    of : digest of image, depth and camera; images : by their path below the folder, none where the frame was left out
    """

    of: str
    light: Light
    images: dict[str, str]


@dataclass
class Done:
    """What became of one frame: files and bytes written, files that were there, warnings, error.

    again : files that were there, but not as this frame gives them
    """

    id: str
    blue: bool = False
    made: int = 0
    kept: int = 0
    again: int = 0
    bytes: int = 0
    warnings: list[str] = field(default_factory=list)
    error: str = ""
    frame: Made = field(default_factory=lambda: Made("", (0, 0, 0, 0, 0), {}))

    def add(self, other: "Done") -> None:
        """Count another frame's files in, and take over its warnings."""
        for name in ("made", "kept", "again", "bytes"):
            setattr(self, name, getattr(self, name) + getattr(other, name))
        self.warnings += other.warnings


Make = Callable[[set[Path], Done], None]
"""Makes the wanted images of a frame, and tells of airlight and warnings."""


def fog_frames(frames: list[Frame], job: Job, processes: int, known: dict[str, Made]) -> Generator[Done, None, None]:
    """Fog frame by frame, results in the order of `frames`.

    known : what was made of frames before, by their id

    Raises FoggyError if a process dies; what is wrong with a frame stands in its result.
    """
    tasks = [(frame, job, known.get(frame.id)) for frame in frames]
    yield from in_processes(
        _fog_frame, tasks, min(processes, len(frames)), lambda task: f"frame {task[0].id}", rendering.keep_memory
    )


def _fog_frame(task: tuple[Frame, Job, Made | None]) -> Done:
    return fog_frame(*task)


def fog_frame(frame: Frame, job: Job, known: Made | None = None) -> Done:
    """Make what is missing of one frame, and what is not as it was made of these very inputs."""
    done = Done(frame.id)
    try:
        of, make = job.open(frame)
        if known is not None and known.of != of:
            known = None
        paths = [path for kind in job.paths(frame) for path in kind]
        wanted = {path for path in paths if not _is_right(path, job.name(path), known)}
        if known is not None and (not wanted or not known.images):
            done.frame, done.blue, done.kept = known, not known.images, len(paths) - len(wanted)
            return done
        done.kept, done.again = len(paths) - len(wanted), sum(os.path.lexists(path) for path in wanted)
        done.frame = Made(of, done.frame.light, dict(known.images) if known else {})
        make(wanted, done)
        settings.claim(job.out, job.stated)  # for a frame that was left out, which is known by that, too
    except FoggyError as error:
        done.error = str(error)
    except OSError as error:
        done.error = f"{error.filename or frame.rgb}: {error.strerror} (frame {frame.id})"
    except UNFORESEEN as error:  # one frame must not stop a hundred thousand others, nor stay unnamed
        done.error = f"{frame.rgb}: frame {frame.id} cannot be fogged: {type(error).__name__}: {error}"
    return done


def _make(frame: Frame, job: Job, rgb: bytes, depth: bytes, camera: Camera, wanted: set[Path], done: Done) -> None:
    # What is no PNG is read by a library that opens files itself.
    source = rgb if rgb.startswith(SIGNATURE) else frame.rgb
    clear = rendering.read_clear(source, depth, str(frame.rgb), str(frame.depth))
    render(frame, job, clear, rendering.rays_of(clear, camera, str(frame.camera), job.geometry), wanted, done)


def render(frame: Frame, job: Job, clear: rendering.Clear, rays: Rays, wanted: set[Path], done: Done) -> None:
    """Write the wanted images of a frame that was read, and note airlight and warnings."""
    light = take_airlight(clear.image, job, done)
    done.warnings = [*clear.warnings(light), *clear.hidden(job.betas)]
    if not (done.blue and job.treatment == rendering.DROP):
        write(job, _encoded(frame, job, clear, rays, light, wanted), done)


def _encoded(
    frame: Frame, job: Job, clear: rendering.Clear, rays: Rays, light: Airlight, wanted: set[Path]
) -> Iterator[tuple[Path, bytes]]:
    foggy, maps = job.paths(frame)
    kinds = (
        (foggy, partial(job.foggy_files, clear, rays, light)),
        (maps, partial(rendering.transmittance_pngs, job.model, clear, rays, level=job.level)),
    )
    for paths, encode in kinds:
        missing = {path: beta for path, beta in zip(paths, job.betas, strict=False) if path in wanted}
        if missing:
            yield from zip(missing, encode(betas=list(missing.values())), strict=True)


def take_airlight(image: np.ndarray, job: Job, done: Done) -> Airlight:
    """Airlight of a frame's image, uint8 (H, W, 3), which is noted in `done`."""
    light, done.blue = rendering.airlight_of(image, job.treatment)
    done.frame = replace(done.frame, light=(*light.levels, light.row, light.column))
    return light


def write(job: Job, files: Iterable[tuple[Path, bytes]], done: Done) -> None:
    """Write files as they come, and note them in `done`."""
    # Files are synced one by one: several at a time wait for the disk together.
    with ThreadPoolExecutor(WRITERS) as writer:
        pending = []
        for path, data in files:
            if not done.made:
                settings.claim(job.out, job.stated)
            pending.append(writer.submit(write_bytes, path, data))
            done.frame.images[job.name(path)] = sha256_bytes(data)
            done.made += 1
            done.bytes += len(data)
        for written in pending:
            written.result()


def read_input(frame: Frame, path: Path, number: int) -> bytes:
    """Content of one of a frame's `files`, checked against what it must have, where that is known."""
    data = read_bytes(path, "file", f"It is of frame {frame.id}.")
    if frame.checksums and (digest := sha256_bytes(data)) != (wanted := frame.checksums[number]):
        raise FoggyError(f"{path}: its sha256 is {digest[:12]}..., but --checksums has {wanted[:12]}...")
    return data


def _is_right(path: Path, name: str, known: Made | None) -> bool:
    """Whether an image is the one that an earlier run made."""
    return known is not None and name in known.images and path.is_file() and sha256(path) == known.images[name]
