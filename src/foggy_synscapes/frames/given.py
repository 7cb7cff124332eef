"""Fog on frames of any origin: depth in any format and unit, missing depth answered, images as PNG or JPEG."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from foggy_synscapes.depth.decoding import DISPARITY, METRES, RAY, Encoding, decode
from foggy_synscapes.depth.filling import fill
from foggy_synscapes.depth.refinement import composite
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.fog.airlight import Airlight
from foggy_synscapes.fog.geometry import Rays, straight
from foggy_synscapes.fog.models import chosen
from foggy_synscapes.frames import folders, rendering
from foggy_synscapes.frames.cameras import Intrinsics, of_fov, parse
from foggy_synscapes.frames.finding import Frame
from foggy_synscapes.frames.stereo import FARTHEST, NEAREST
from foggy_synscapes.io.depth_files import read_map, read_stored
from foggy_synscapes.io.hashing import sha256_bytes
from foggy_synscapes.io.images import encode_png
from foggy_synscapes.io.pictures import QUALITY, encode_jpeg, read_picture

PNG, JPEG = "png", "jpg"
HOMOGENEOUS = "homogeneous"
REFUSE, FAR, COMPLETE = "refuse", "far", "complete"
ANSWERS = (REFUSE, FAR, COMPLETE)
"""What to do where pixels have no depth: refuse the frame, take them for infinitely far, or complete them."""
STEP = 4
"""Of rows and columns, for the median of a depth map: it is to tell metres from millimetres."""


@dataclass(frozen=True)
class GivenFrame(Frame):
    """A frame of any origin; `id` is its path below the folder of images, without ending, which its outputs keep.

    camera : its file, or the depth file where there is none; in_depth : whether that one's header has the camera
    """

    in_depth: bool = False

    def files(self) -> tuple[Path, ...]:
        """All files that it is made of."""
        return tuple(dict.fromkeys((self.rgb, self.depth, self.camera)))


@dataclass(frozen=True)
class GivenJob(folders.Job):
    """What to make of frames of any origin.

    encoding : what the values of their depth files mean; channel : of an EXR, or the name of an array
    missing : one of ANSWERS
    intrinsics : of all frames, or their horizontal angle of view in degrees; None: each frame's file has it
    baseline : metres between both views, of disparity where the camera's file has none
    ending : of foggy images, "png" or "jpg"; quality : of JPEG
    """

    encoding: Encoding = METRES
    channel: str = ""
    missing: str = REFUSE
    intrinsics: Intrinsics | float | None = None
    baseline: float | None = None
    ending: str = PNG
    quality: int = QUALITY

    def paths(self, frame: Frame) -> tuple[list[Path], list[Path]]:
        """Foggy images and transmittance maps of a frame, one per beta; maps are PNG."""
        folder = {beta: self.out / f"beta_{beta}" for beta in self.betas}
        foggy = [place / "foggy_img" / f"{frame.id}_beta_{beta}.{self.ending}" for beta, place in folder.items()]
        maps = [place / "transmittance" / f"{frame.id}_beta_{beta}.{PNG}" for beta, place in folder.items()]
        return foggy, maps if self.transmittance else []

    def settings(self) -> dict[str, Any]:
        """What else decides the pixels."""
        # JSON has no infinity.
        about = {f"depth_{name}": str(value) for name, value in vars(self.encoding).items()}
        return {
            **super().settings(),
            **about,
            "depth_channel": self.channel,
            "missing": self.missing,
            "intrinsics": str(self.intrinsics),
            "baseline": self.baseline,
            "format": self.ending if self.ending == PNG else f"{self.ending}, quality {self.quality}",
        }

    def open(self, frame: Frame) -> tuple[str, folders.Make]:
        """Read a frame's files; what makes it raises FoggyError where they cannot be understood or do not fit."""
        assert isinstance(frame, GivenFrame)
        contents, found = self._contents(frame)
        camera = vars(found) if isinstance(found, Intrinsics) else found
        about = sha256_bytes(contents[frame.rgb]), sha256_bytes(contents[frame.depth]), camera
        of = sha256_bytes(json.dumps(about).encode())
        return of, partial(self._make, frame, contents[frame.rgb], contents[frame.depth], found)

    def clear(self, frame: GivenFrame) -> tuple[rendering.Clear, Rays, list[str]]:
        """A frame as read, the rays of its camera, and what may be wrong with it; raises FoggyError as `open` does."""
        contents, found = self._contents(frame)
        return self._clear(frame, contents[frame.rgb], contents[frame.depth], found)

    def _contents(self, frame: GivenFrame) -> tuple[dict[Path, bytes], Intrinsics | float | None]:
        """The bytes of a frame's files, and its camera or angle of view."""
        contents = {path: folders.read_input(frame, path, n) for n, path in enumerate(frame.files())}
        found: Intrinsics | float | None = self.intrinsics
        if found is None and frame.camera != frame.depth:
            found = parse(contents[frame.camera], frame.camera, frame.rgb)
        if found is None and frame.in_depth:
            found = Intrinsics(**vars(rendering.read_camera(frame.depth)))
        return contents, found

    def _make(
        self, frame: Frame, rgb: bytes, depth: bytes, about: Intrinsics | float | None, wanted: set[Path],
        done: folders.Done,
    ) -> None:  # fmt: skip
        clear, rays, warnings = self._clear(frame, rgb, depth, about)
        folders.render(frame, self, clear, rays, wanted, done)
        done.warnings = warnings + done.warnings

    def _clear(
        self, frame: Frame, rgb: bytes, depth: bytes, about: Intrinsics | float | None
    ) -> tuple[rendering.Clear, Rays, list[str]]:
        image, stored = read_picture(rgb, frame.rgb), read_stored(depth, frame.depth, self.channel)
        _same_size(image, stored, frame)
        found = of_fov(about, image.shape) if isinstance(about, float) else about
        metres, warnings = self._metres(image, stored, found, frame)
        name = str(frame.camera)
        if self.encoding.meaning == RAY or found is None:
            rays = straight(metres.shape)
        else:
            camera = found.camera(image.shape, name)
            if not (0 <= camera.u0 <= camera.resx and 0 <= camera.v0 <= camera.resy):
                warnings.append(
                    f"{name}: its principal point ({camera.u0:g}, {camera.v0:g}) lies outside of the image of "
                    f"{camera.resx} x {camera.resy} pixels. Is it the camera of this resolution?"
                )
            rays = rendering.rays_of_camera(camera, self.geometry)
        return rendering.Clear(image, metres, str(frame.rgb), str(frame.depth), 0), rays, warnings

    def _metres(
        self, image: np.ndarray, stored: np.ndarray, camera: Intrinsics | None, frame: Frame
    ) -> tuple[np.ndarray, list[str]]:
        """Depth, float32 (H, W), without holes, and what may be wrong with it."""
        name, baseline = str(frame.depth), self.baseline or (camera.baseline if camera else None)
        if self.encoding.meaning == DISPARITY and not (camera and baseline):
            raise FoggyError(
                f"{frame.camera}: has no baseline, the metres between both views, without which disparity is no depth. "
                "Give --baseline, or the file of the stereo camera."
            )
        try:
            metres = decode(stored, self.encoding, camera.fx if camera else 0.0, baseline or 0.0)
        except ValueError as error:
            raise FoggyError(f"{name}: {error}") from error
        warnings = [*_odd_median(metres, name)]
        missing = np.isnan(metres)
        count = int(np.count_nonzero(missing))
        if not count:
            return _single(metres), warnings
        what = f"{name}: {count:,} of {metres.size:,} pixels ({count / metres.size:.1%}) have no depth"
        if count == metres.size:
            raise FoggyError(f"{name}: no pixel has depth; all are 0, negative or not a number. Fetch the file again.")
        if self.missing == REFUSE:
            raise FoggyError(
                f"{what}: 0, negative or not a number. Say what they are: --missing far (infinitely far, as sky), or "
                "--missing complete (from the image and the depth around them)"
            )
        if self.missing == FAR:
            metres[missing] = np.inf
            return _single(metres), [*warnings, f"{what}, and are taken for infinitely far"]
        try:
            return _single(fill(image, metres)), [*warnings, f"{what}, and were completed"]
        except ValueError as error:
            raise FoggyError(f"{name}: {error}. Take --missing far, or denser depth.") from error

    def foggy_files(self, clear: rendering.Clear, rays: Rays, light: Airlight, betas: Sequence[str]) -> Iterator[bytes]:
        """Foggy images as files, one per beta."""
        if self.ending == PNG:
            return super().foggy_files(clear, rays, light, betas)
        return (self._jpeg(clear, rays, light, float(beta)) for beta in betas)

    def _jpeg(self, clear: rendering.Clear, rays: Rays, light: Airlight, beta: float) -> bytes:
        frame, model = (clear.image, clear.depth, rays, light.levels), chosen(self.model)
        if model.choose is not None:
            model = chosen(model.choose(*frame, beta).model)
        return encode_jpeg(model.images(*frame, [beta])[0], self.quality)


@dataclass(frozen=True)
class MapJob(GivenJob):
    """Fog by given maps of transmittance, of one beta, in the place of depth."""

    def open(self, frame: Frame) -> tuple[str, folders.Make]:
        """Read a frame's files; see `GivenJob.open`."""
        rgb, depth = (folders.read_input(frame, path, n) for n, path in enumerate((frame.rgb, frame.depth)))
        of = sha256_bytes(json.dumps((sha256_bytes(rgb), sha256_bytes(depth))).encode())
        return of, partial(self._compose, frame, rgb, depth)

    def _compose(self, frame: Frame, rgb: bytes, depth: bytes, wanted: set[Path], done: folders.Done) -> None:
        image, stored = read_picture(rgb, frame.rgb), read_map(depth, frame.depth, self.channel)
        _same_size(image, stored, frame)
        whole = {"uint8": 255, "uint16": 65535}.get(stored.dtype.name, 1)
        values = stored.astype(np.float64) / whole
        if values.ndim != 2 or not ((values >= 0) & (values <= 1)).all():
            raise FoggyError(
                f"{frame.depth}: holds {stored.dtype} {stored.shape}, not all of it from 0 to {whole}. Is this a "
                "map of transmittance?"
            )
        if values.max() == 0:
            done.warnings.append(f"{frame.depth}: transmittance is 0 everywhere, so that only fog is seen")
        light = folders.take_airlight(image, self, done)
        if done.blue and self.treatment == rendering.DROP:
            return
        foggy = composite(image, values, light.levels)
        data = encode_jpeg(foggy, self.quality) if self.ending == JPEG else encode_png(foggy, max(self.level, 1))
        folders.write(self, ((path, data) for path in wanted), done)


def _same_size(image: np.ndarray, stored: np.ndarray, frame: Frame) -> None:
    if stored.shape[:2] != image.shape[:2]:
        (rows, columns), (height, width) = stored.shape[:2], image.shape[:2]
        turned = " Is it turned by a quarter?" if (columns, rows) == (height, width) else ""
        raise FoggyError(
            f"{frame.depth}: {columns} x {rows} pixels, but {frame.rgb} has {width} x {height}. "
            f"Are they of the same frame and resolution?{turned}"
        )


def _single(metres: np.ndarray) -> np.ndarray:
    with np.errstate(over="ignore"):  # beyond what float32 holds is infinitely far
        return metres.astype(np.float32)


def _odd_median(metres: np.ndarray, name: str) -> Iterator[str]:
    """A warning where the unit can hardly be right."""
    finite = metres[::STEP, ::STEP]
    finite = finite[np.isfinite(finite)]
    median = float(np.median(finite)) if finite.size else NEAREST
    if not NEAREST <= median <= FARTHEST:
        yield (
            f"{name}: its median depth is {median:,.3g} m. Is it in millimetres or centimetres? --depth-scale says how "
            "many metres a unit is, e.g. 0.001"
        )
