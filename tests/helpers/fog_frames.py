"""Small frames in the layout of Synscapes, for the tests of fog."""

import json
from pathlib import Path

import numpy as np

from foggy_synscapes.camera import Camera
from foggy_synscapes.datasets import synscapes
from foggy_synscapes.io.atomic import write_bytes, write_text
from foggy_synscapes.io.images import encode_depth, encode_png

SIZE = (24, 40)
CAMERA = Camera(fx=44.0, fy=45.0, u0=20.5, v0=11.5, resx=SIZE[1], resy=SIZE[0])


def camera_json(camera: Camera = CAMERA) -> str:
    return json.dumps({"camera": {"intrinsic": vars(camera), "extrinsic": {"x": 1.7}}})


def content(frame: int) -> tuple[np.ndarray, np.ndarray]:
    """Image and depth of a frame: grey noise under an overcast sky at 8 km; of every fifth frame the sky is blue."""
    rng = np.random.default_rng(frame)
    image = rng.integers(0, 200, (*SIZE, 3), dtype=np.uint8)
    depth = (3 + 200 * rng.random(SIZE)).astype(np.float32)
    image[:16], depth[:16] = ((150, 190, 240) if frame % 5 == 0 else (251, 255, 249)), 8000
    return image, depth


def write_frame(root: Path, frame: int) -> None:
    image, depth = content(frame)
    write_bytes(root / synscapes.rgb(frame), encode_png(image))
    write_bytes(root / synscapes.depth(frame), encode_depth(depth))
    write_text(root / synscapes.meta(frame), camera_json())


def write_frames(root: Path, count: int) -> Path:
    for frame in range(1, count + 1):
        write_frame(root, frame)
    return root


def tree(folder: Path) -> dict[str, bytes]:
    """Every file below a folder and its bytes."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()
    }
