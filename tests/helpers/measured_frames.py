"""Frames of 1440 x 720 pixels to measure fog on, real or generated, and the CPU time of a call."""

import os
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from foggy_synscapes.camera import Camera
from foggy_synscapes.datasets.synscapes import read_camera
from foggy_synscapes.io.images import encode_depth, encode_png

REAL = "synscapes"  # folder of the real frames below --samples
CAMERA = Camera(fx=1590.8, fy=1592.8, u0=771.3, v0=360.8, resx=1440, resy=720)


def generated(seed: int) -> tuple[bytes, bytes]:
    """A frame of blocks and noise under a white sky at 8 km."""
    rng = np.random.default_rng(seed)
    blocks = np.kron(rng.integers(20, 200, (36, 72, 3)), np.ones((20, 20, 1))).astype(np.int64)
    image = (blocks + rng.integers(-6, 7, blocks.shape)).clip(0, 255).astype(np.uint8)
    depth = 5 + 150 * np.linspace(1, 0, 720)[:, None] ** 3 + rng.random((720, 1440))
    image[:200], depth[:200] = (251, 255, 249), 8000 + rng.random((200, 1440))
    return encode_png(image, 0), encode_depth(depth.astype(np.float32))


def frames(folder: Path, count: int, samples: Path) -> Camera:
    """Fill a folder in the layout of Synscapes with `count` frames, two different ones in turn."""
    for name in ("rgb", "depth"):
        (folder / "img" / name).mkdir(parents=True)
    real = samples / REAL
    for number in range(1, count + 1):
        paths = folder / f"img/rgb/{number}.png", folder / f"img/depth/{number}.exr"
        kind = 2 - number % 2
        if number <= 2:
            sources = real / f"img/rgb/{kind}.png", real / f"img/depth/{kind}.exr"
            data = [path.read_bytes() for path in sources] if real.is_dir() else generated(kind)
            for path, content in zip(paths, data, strict=True):
                path.write_bytes(content)
        else:
            for path in paths:
                os.link(path.with_stem(str(kind)), path)
    camera = read_camera(real / "camera.json") if real.is_dir() else CAMERA
    text = '{"camera": {"intrinsic": ' + str(vars(camera)).replace("'", '"') + "}}"
    (folder / "camera.json").write_text(text)
    return camera


def cpu(call: Callable[[], object]) -> float:
    """Seconds of this thread that a call takes."""
    started = time.thread_time()
    call()
    return time.thread_time() - started
