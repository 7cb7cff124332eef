"""One frame from its files: read, fog at several betas, encode."""

import ctypes
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from foggy_synscapes.camera import Camera
from foggy_synscapes.datasets import synscapes
from foggy_synscapes.datasets.index import expect
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.fog.airlight import Airlight, estimate
from foggy_synscapes.fog.geometry import Rays, camera_from_window, rays
from foggy_synscapes.fog.models import chosen
from foggy_synscapes.fog.optics import count_zero_depth, meteorological_optical_range
from foggy_synscapes.io.hashing import read_checked
from foggy_synscapes.io.images import encode_png, read_depth, read_depth_header, read_rgb
from foggy_synscapes.io.png_text import with_note

KEEP, DROP, GREY = "keep", "drop", "grey"
"""What to do where the airlight is blue (paper, section III, failure case)."""

NOTE = "fog model"
"""Under this key, an image of a model that chooses another one has a note of which and why."""

M_TRIM_THRESHOLD, M_MMAP_THRESHOLD = -1, -3  # malloc.h


@dataclass(frozen=True)
class Clear:
    """A frame as read: image uint8 (H, W, 3), planar depth float32 (H, W) in metres, and what errors call them."""

    image: np.ndarray
    depth: np.ndarray
    rgb_name: str
    depth_name: str
    at_zero: int  # pixels at distance 0

    def warnings(self, light: Airlight) -> list[str]:
        """What may be wrong with this frame, though fog on it is defined."""
        found = []
        if self.at_zero:
            found.append(f"{self.depth_name}: {self.at_zero} pixels at distance 0, which usually means missing depth")
        if light.levels == (0, 0, 0):
            found.append(f"{self.rgb_name}: its airlight is black, so its fog is black")
        return found

    def hidden(self, betas: Sequence[str]) -> list[str]:
        """Betas in 1/m at which not even the nearest pixel is seen, as warnings."""
        nearest = float(self.depth.min())
        far = {beta: meteorological_optical_range(float(beta)) for beta in betas if float(beta)}
        return [
            f"{self.depth_name}: nothing is nearer than {nearest:.3g} m, but the visibility at beta {beta} / m is "
            f"{sight:.3g} m"
            for beta, sight in far.items()
            if sight < nearest
        ]


def keep_memory() -> None:
    """Let this process keep what it frees, up to 256 MB, for the next frame.

    The C library hands blocks as large as images back to the system each time, and clearing fresh pages for the
    next one takes a tenth of a frame's time. Where there is no glibc, nothing happens.
    """
    library = ctypes.CDLL(None)
    if hasattr(library, "mallopt"):
        library.mallopt(M_MMAP_THRESHOLD, 32 << 20)
        library.mallopt(M_TRIM_THRESHOLD, 256 << 20)


def read_clear(rgb: Path | bytes, depth: Path | bytes, rgb_name: str, depth_name: str) -> Clear:
    """Decode a frame and make sure that image and depth belong together.

    Raises
    ------
    FoggyError
        If a file is damaged or of another kind, sizes differ, or a depth is negative or not a number.
    """
    image, metres = read_rgb(rgb, rgb_name), read_depth(depth, depth_name)
    if image.shape[:2] != metres.shape:
        raise FoggyError(
            f"{depth_name}: {_size(metres)} pixels, but {rgb_name} has {_size(image)}. "
            "Are they of the same frame and resolution?"
        )
    try:
        return Clear(image, metres, rgb_name, depth_name, count_zero_depth(metres))
    except ValueError as error:
        raise FoggyError(f"{depth_name}: {error}. Fetch the file again, or repair it at its source.") from error


def read_frame(folder: Path, frame: int, index: Mapping[str, str]) -> Clear:
    """Read a frame of Synscapes whose files have to be as they were indexed."""
    paths = synscapes.rgb(frame), synscapes.depth(frame)
    rgb, depth = (read_indexed(folder, path, index) for path in paths)
    return read_clear(rgb, depth, str(folder / paths[0]), str(folder / paths[1]))


def read_indexed(folder: Path, path: str, index: Mapping[str, str]) -> bytes:
    """Read a file of Synscapes that has to be as it was indexed."""
    expect(index, [path], "synscapes")
    return read_checked(folder / path, index[path])


def read_camera(path: Path) -> Camera:
    """Camera of a frame, from a JSON file or from the header of a depth file of Synscapes.

    Raises FoggyError if there is none.
    """
    if path.suffix != ".exr":
        return synscapes.read_camera(path)
    header = read_depth_header(path)
    missing = [name for name in ("camera:zoom", "image:window") if name not in header]
    if missing:
        raise FoggyError(
            f"{path}: its header has no {' and no '.join(missing)}. Give the camera as a file: --camera FILE"
        )
    (left, top), (right, bottom) = header["dataWindow"]
    try:
        columns, rows = ((float(first), float(last)) for first, last in header["image:window"])
        return camera_from_window(
            float(header["camera:zoom"]), columns, rows, int(right - left) + 1, int(bottom - top) + 1
        )
    except (ValueError, TypeError, IndexError, ArithmeticError) as error:
        raise FoggyError(f"{path}: camera in its header: {error}. Give it as a file: --camera FILE") from error


def airlight_of(image: np.ndarray, treatment: str) -> tuple[Airlight, bool]:
    """Airlight to use, and whether the image's own is blue; `treatment` grey takes its colour away then."""
    light = estimate(image)
    blue = light.is_blue()
    return (light.grey() if blue and treatment == GREY else light), blue


def rays_of(clear: Clear, camera: Camera, camera_name: str, geometry: str) -> Rays:
    """Rays of a frame's camera; FoggyError if the camera is of another size than the frame."""
    if clear.depth.shape != (camera.resy, camera.resx):
        raise FoggyError(
            f"{camera_name}: its camera has {camera.resx} x {camera.resy} pixels, but {clear.depth_name} has "
            f"{_size(clear.depth)}. Give the camera of these images."
        )
    return rays_of_camera(camera, geometry)


def foggy_pngs(model: str, clear: Clear, rays: Rays, light: Airlight, betas: list[str], level: int) -> Iterator[bytes]:
    """Foggy images by a fog model as PNG, one per beta in 1/m; `level` 0: for photographs, 1 to 3: deflate's effort."""
    # Imported here: its loops are compiled, and Numba takes half a second.
    from foggy_synscapes.io.photographs import encode_photographs

    frame = clear.image, clear.depth, rays, light.levels, [float(beta) for beta in betas]
    found = chosen(model)
    if found.choose is not None:
        for beta in betas:
            choice = found.choose(*frame[:4], float(beta))
            (png,) = foggy_pngs(choice.model, clear, rays, light, [beta], level)
            yield with_note(png, NOTE, f"{choice.model}: {choice.why}")
        return
    if level or found.scan_lines is None:
        yield from (encode_png(image, max(level, 1)) for image in found.images(*frame))
        return
    # A few rows at a time: what was rendered is encoded while the processor's cache still has it.
    yield from encode_photographs((len(betas), *clear.depth.shape), found.scan_lines(*frame))


def transmittance_pngs(model: str, clear: Clear, rays: Rays, betas: list[str], level: int) -> Iterator[bytes]:
    """Transmittance in 8 bits as PNG, one per beta in 1/m."""
    maps = chosen(model).transmittances(clear.depth, rays, [float(beta) for beta in betas])
    yield from (encode_png(one, max(level, 1)) for one in maps)  # smooth maps repeat: matches pay


@lru_cache(maxsize=8)
def rays_of_camera(camera: Camera, geometry: str) -> Rays:
    """Rays of a camera; those of the last few are kept."""
    return rays(camera, geometry)


def _size(values: np.ndarray) -> str:
    return f"{values.shape[1]} x {values.shape[0]}"
