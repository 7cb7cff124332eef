"""Fog on folders of frames, without a pipeline: many processes, what is finished is kept, the broken are named."""

from collections.abc import Generator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from foggy_synscapes.errors import UNFORESEEN, FoggyError
from foggy_synscapes.fog.airlight import Airlight
from foggy_synscapes.frames import rendering
from foggy_synscapes.frames.finding import Frame
from foggy_synscapes.io.atomic import write_bytes
from foggy_synscapes.io.images import is_whole_png, read_rgb
from foggy_synscapes.io.processes import in_processes

Light = tuple[int, int, int, int, int]
"""Row of the airlight table without its id: red, green, blue, row, column."""

WRITERS = 8


@dataclass(frozen=True)
class Job:
    """What to make of each frame; `betas` as text in 1/m, `level` the deflate effort, `model` of fog."""

    out: Path
    betas: list[str]
    geometry: str
    transmittance: bool
    level: int
    treatment: str
    model: str = "homogeneous"

    def paths(self, frame: Frame) -> tuple[list[Path], list[Path]]:
        """Foggy images and transmittance maps of a frame, one per beta."""
        foggy = [self.out / f"beta_{beta}" / "foggy_img" / frame.name(beta) for beta in self.betas]
        maps = [self.out / f"beta_{beta}" / "transmittance" / frame.name(beta) for beta in self.betas]
        return foggy, maps if self.transmittance else []


@dataclass
class Done:
    """What became of one frame: its airlight row, files and bytes written, files that were there, warnings, error."""

    id: str
    light: Light = (0, 0, 0, 0, 0)
    blue: bool = False
    made: int = 0
    kept: int = 0
    bytes: int = 0
    warnings: list[str] = field(default_factory=list)
    error: str = ""

    def add(self, other: "Done") -> None:
        """Count another frame's files in, and take over its warnings."""
        self.made, self.kept, self.bytes = self.made + other.made, self.kept + other.kept, self.bytes + other.bytes
        self.warnings += other.warnings


def fog_frames(frames: list[Frame], job: Job, processes: int, known: dict[str, Light]) -> Generator[Done, None, None]:
    """Fog frame by frame, results in the order of `frames`.

    known : airlight by frame id, of frames whose image did not change since

    Raises FoggyError if a process dies; what is wrong with a frame stands in its result.
    """
    tasks = [(frame, job, known.get(frame.id)) for frame in frames]
    yield from in_processes(
        _fog_frame, tasks, min(processes, len(frames)), lambda task: f"frame {task[0].id}", rendering.keep_memory
    )


def _fog_frame(task: tuple[Frame, Job, Light | None]) -> Done:
    return fog_frame(*task)


def fog_frame(frame: Frame, job: Job, known: Light | None = None) -> Done:
    """Make what is missing of one frame."""
    done = Done(frame.id)
    try:
        foggy, maps = job.paths(frame)
        newest = max(changed(path) for path in _inputs(frame))
        wanted = {path for path in (*foggy, *maps) if not _is_right(path, newest)}
        done.kept = len(foggy) + len(maps) - len(wanted)
        if wanted:
            _make(frame, job, wanted, done)
        else:
            done.light = known or _light(rendering.airlight_of(read_rgb(frame.rgb), job.treatment)[0])
    except FoggyError as error:
        done.error = str(error)
    except OSError as error:
        done.error = f"{error.filename or frame.rgb}: {error.strerror} (frame {frame.id})"
    except UNFORESEEN as error:  # one frame must not stop a hundred thousand others, nor stay unnamed
        done.error = f"{frame.rgb}: frame {frame.id} cannot be fogged: {type(error).__name__}: {error}"
    return done


def _make(frame: Frame, job: Job, wanted: set[Path], done: Done) -> None:
    clear = rendering.read_clear(frame.rgb, frame.depth, str(frame.rgb), str(frame.depth))
    camera, camera_name = rendering.read_camera(frame.camera), str(frame.camera)
    light, done.blue = rendering.airlight_of(clear.image, job.treatment)
    done.light = _light(light)
    done.warnings = clear.warnings(light)
    if done.blue and job.treatment == rendering.DROP:
        return
    foggy, maps = job.paths(frame)
    rays = rendering.rays_of(clear, camera, camera_name, job.geometry)
    # Files are synced one by one: several at a time wait for the disk together.
    with ThreadPoolExecutor(WRITERS) as writer:
        kinds = (
            (foggy, partial(rendering.foggy_pngs, job.model, clear, rays, light)),
            (maps, partial(rendering.transmittance_pngs, job.model, clear, rays)),
        )
        pending = []
        for paths, encode in kinds:
            missing = {path: beta for path, beta in zip(paths, job.betas, strict=False) if path in wanted}
            for path, data in zip(missing, encode(list(missing.values()), job.level) if missing else (), strict=True):
                pending.append(writer.submit(write_bytes, path, data))
                done.made += 1
                done.bytes += len(data)
        for written in pending:
            written.result()


def _light(light: Airlight) -> Light:
    return (*light.levels, light.row, light.column)


def _inputs(frame: Frame) -> tuple[Path, ...]:
    inputs = (frame.rgb, frame.depth, frame.camera)
    for path in inputs:
        if not path.is_file():
            raise FoggyError(f"{path}: missing (frame {frame.id})")
    return inputs


def changed(path: Path) -> int:
    """When a file was last written or put into its place, in ns: a copy that keeps an old time is new all the same.

    Where it is a symbolic link, also when that was.
    """
    return max(time for status in (path.stat(), path.lstat()) for time in (status.st_mtime_ns, status.st_ctime_ns))


def _is_right(path: Path, newest: int) -> bool:
    """Whether an image was finished by an earlier run, after its inputs were last changed."""
    return path.is_file() and path.stat().st_mtime_ns >= newest and is_whole_png(path)
