"""Camera files of any dataset, told apart by what they hold, and cameras stated on the command line.

Read are JSON as Synscapes and Cityscapes have it, plain JSON with fx, fy, u0 (or cx), v0 (or cy) or a matrix K, and the
text files of KITTI and Virtual KITTI 2.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from foggy_synscapes.camera import Camera
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.frames import rendering
from foggy_synscapes.io.files import named, number, parse_json, read_bytes

NAMES = {
    "fx": ("fx",), "fy": ("fy",), "u0": ("u0", "cx"), "v0": ("v0", "cy"),
    "resx": ("resx", "width"), "resy": ("resy", "height"), "baseline": ("baseline",),
}  # fmt: skip
MATRICES = ("K", "camera_intrinsic", "camera_matrix", "intrinsic_matrix")
ADVICE = (
    "Read are camera files of Synscapes, Cityscapes and KITTI, and JSON with fx, fy, u0, v0 in pixels; or give "
    "--fov or --intrinsics."
)
LEFT = 2
"""KITTI's left colour camera, where a path does not tell another one."""
PARTNERS = {0: 1, 1: 0, 2: 3, 3: 2}
"""KITTI's cameras on one bar: grey left and right, colour left and right."""


@dataclass(frozen=True)
class Intrinsics:
    """A camera whose image size may be unknown: pixels as in `Camera`, and metres between both views, if it has two."""

    fx: float
    fy: float
    u0: float
    v0: float
    resx: int | None = None
    resy: int | None = None
    baseline: float | None = None

    def camera(self, shape: tuple[int, ...], name: str) -> Camera:
        """The camera of images of so many rows and columns; FoggyError, calling it `name`, if it is of other images."""
        height, width = shape[:2]
        if (self.resx or width, self.resy or height) != (width, height):
            raise FoggyError(
                f"{name}: its camera has {self.resx} x {self.resy} pixels, but the image has {width} x {height}. "
                "Give the camera of these images."
            )
        try:
            return Camera(self.fx, self.fy, self.u0, self.v0, width, height)
        except ValueError as error:
            raise FoggyError(f"{name}: {error}") from error


def of_fov(degrees: float, shape: tuple[int, ...]) -> Intrinsics:
    """A camera that looks straight through the middle of its image, by its horizontal angle of view.

    >>> of_fov(90, (100, 200))
    Intrinsics(fx=100.0, fy=100.0, u0=100.0, v0=50.0, resx=200, resy=100, baseline=None)

    Raises ValueError if the angle is not between 0 and 180 degrees.
    """
    if not 0 < degrees < 180:
        raise ValueError(f"angle of view {degrees} degrees, expected between 0 and 180")
    height, width = shape[:2]
    focal = round(width / 2 / math.tan(math.radians(degrees) / 2), 9)
    return Intrinsics(focal, focal, width / 2, height / 2, width, height)


def read_camera(path: Path, shape: tuple[int, ...] | None = None) -> Camera:
    """The camera of a file of any dataset, or of the header of a depth file of Synscapes.

    shape : rows and columns of its images, for files that do not say them

    Raises FoggyError if the file is missing or holds no camera, or nobody says how large its images are.
    """
    if path.suffix == ".exr":
        return rendering.read_camera(path)
    found = parse(read_bytes(path, "camera file", ADVICE), path)
    rows, columns = shape or (0, 0)
    rows, columns = found.resy or rows, found.resx or columns
    if not (rows and columns):
        raise FoggyError(f"{path}: does not say how large its images are. Add resx and resy, in pixels.")
    return found.camera((rows, columns), str(path))


def parse(data: bytes, path: Path, image: Path = Path()) -> Intrinsics:
    """The camera that a file holds.

    data : content of the file at `path`; image : its folder names the camera where a file holds several, e.g. image_02

    Raises FoggyError if it holds none, or a number of it is missing or wrong.
    """
    if data.lstrip()[:1] in (b"{", b"["):
        return _of_json(parse_json(data, path, "camera file", ADVICE), path)
    with named(path, "camera file", ADVICE):
        lines = [line.split() for line in data.decode("utf-8").splitlines() if line.strip()]
        if lines and lines[0][:2] == ["frame", "cameraID"]:
            return _of_virtual_kitti(lines, image)
        return _of_kitti(lines, _kitti_number(image))


def _of_json(document: Any, path: Path) -> Intrinsics:
    place, extrinsic = _intrinsic(document)
    if not isinstance(place, Mapping):
        raise FoggyError(f"{path}: holds no camera. {ADVICE}")
    found: dict[str, float] = {}
    for name, spellings in NAMES.items():
        own = next((key for key in spellings if key in place), None)
        section = place if own else extrinsic if name in extrinsic else {}
        if section:
            with named(f"{path}: {own or name}", "number"):
                found[name] = number(section[own or name])
    for key in MATRICES:
        if key in place:
            with named(f"{path}: {key}", "matrix", "Expected three rows of three numbers, or the nine in a row."):
                found |= _of_matrix(_rows(place[key]))
    return _whole(found, path)


def _intrinsic(document: Any) -> tuple[Any, Mapping[str, Any]]:
    """Where the numbers of a camera are, and those of its place on the car."""
    for holder in (document.get("camera") if isinstance(document, Mapping) else None, document):
        if isinstance(holder, Mapping) and isinstance(holder.get("intrinsic"), Mapping):
            extrinsic = holder.get("extrinsic")
            return holder["intrinsic"], extrinsic if isinstance(extrinsic, Mapping) else {}
    return document, {}


def _rows(matrix: Any) -> np.ndarray:
    """A matrix as it stands in JSON: rows of numbers, or nine numbers in a row, as ROS writes them."""
    if len(matrix) == 9:
        matrix = [matrix[start : start + 3] for start in (0, 3, 6)]
    return np.array([[number(value) for value in row] for row in matrix])


def _of_matrix(rows: np.ndarray) -> dict[str, float]:
    if rows.shape != (3, 3):
        raise ValueError(f"{rows.shape} numbers, expected (3, 3)")
    return {"fx": rows[0, 0], "fy": rows[1, 1], "u0": rows[0, 2], "v0": rows[1, 2]}


def _whole(found: Mapping[str, float], path: Path) -> Intrinsics:
    missing = [name for name in ("fx", "fy", "u0", "v0") if name not in found]
    if missing:
        raise FoggyError(f"{path}: {', '.join(missing)} missing. {ADVICE}")
    fx, fy, u0, v0 = (float(found[name]) for name in ("fx", "fy", "u0", "v0"))
    resx, resy = (int(found[name]) if name in found else None for name in ("resx", "resy"))
    return Intrinsics(fx, fy, u0, v0, resx, resy, found.get("baseline"))


def _kitti_number(image: Path) -> int:
    """The camera that a folder of KITTI is of: image_02 and image_2 are the left colour camera."""
    names = [re.fullmatch(r"image_0?([0-3])", part) for part in reversed(image.parts)]
    return next((int(match[1]) for match in names if match), LEFT)


def _of_virtual_kitti(lines: list[list[str]], image: Path) -> Intrinsics:
    """Of intrinsic.txt, a line for each frame and camera: frame cameraID fx fy u0 v0."""
    wanted = [re.search(r"(\d+)$", part) for part in (image.stem, image.parent.name)]
    frame, camera = (str(int(match[1])) if match else "0" for match in wanted)
    for line in lines[1:]:
        if line[:2] == [frame, camera] and len(line) == 6:
            return _checked(dict(zip(("fx", "fy", "u0", "v0"), map(float, line[2:]), strict=True)))
    raise ValueError(f"no line of frame {frame} and camera {camera}, which {image} names")


def _of_kitti(lines: list[list[str]], camera: int) -> Intrinsics:
    """Of calib_cam_to_cam.txt, of object and odometry's calib files, or the nine numbers of a matrix."""
    tables: dict[str, list[float]] = {}
    for line in lines:
        key = line[0].removesuffix(":") if line[0].endswith(":") else ""
        words = line[1:] if key else line
        if all(re.fullmatch(r"[-+0-9.eE]+", word) for word in words):  # other lines are dates and names
            tables.setdefault(key, []).extend(map(float, words))
    if len(tables.get("", [])) == 9:
        return _checked(_of_matrix(np.array(tables[""]).reshape(3, 3)))
    own, other = (_projection(tables, each) for each in (camera, PARTNERS[camera]))
    if own is None:
        raise ValueError(f"no projection of camera {camera} (P_rect_0{camera}, P{camera}), and no matrix of 9 numbers")
    found = _checked(_of_matrix(own[:, :3]))
    if other is not None:
        found = replace(found, baseline=abs(float(own[0, 3] - other[0, 3])) / found.fx)
    size = tables.get(f"S_rect_0{camera}")
    return replace(found, resx=int(size[0]), resy=int(size[1])) if size and len(size) == 2 else found


def _projection(tables: Mapping[str, list[float]], camera: int) -> np.ndarray | None:
    for key in (f"P_rect_0{camera}", f"P{camera}"):
        if len(tables.get(key, [])) == 12:
            return np.array(tables[key]).reshape(3, 4)
    return None


def _checked(numbers: Mapping[str, float]) -> Intrinsics:
    if not all(math.isfinite(value) for value in numbers.values()):
        raise ValueError("its numbers are not all finite")
    fx, fy, u0, v0 = (float(numbers[name]) for name in ("fx", "fy", "u0", "v0"))
    return Intrinsics(fx, fy, u0, v0)
