"""Generated files in the layouts of docs/recipes.md: the same small street in every format."""

import io
import json
from collections.abc import Callable
from pathlib import Path

import fog_frames
import numpy as np
import OpenEXR
import OpenImageIO as oiio
import stereo_frames

from foggy_synscapes.io.atomic import write_bytes, write_text
from foggy_synscapes.io.images import RGBA, assemble_png, encode_png
from foggy_synscapes.io.pictures import encode_jpeg

SIZE = ROWS, COLUMNS = 24, 40
FX = 44.0
PLAIN = {"fx": FX, "fy": FX, "u0": 20.0, "v0": 12.0}


def street(number: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Image uint8 (24, 40, 3) and planar depth float64 in metres: a road, a wall, and sky at infinity."""
    rng = np.random.default_rng(number)
    y, _ = np.mgrid[:ROWS, :COLUMNS]
    depth = np.where(y < 6, np.inf, np.where(y < 14, 40.0 + number, 160.0 / np.maximum(y - 10, 1)))
    image = rng.integers(40, 160, (*SIZE, 3)).astype(np.uint8)
    image[:6] = 251, 255, 249
    return image, depth


def png16(depth: np.ndarray, scale: float, far: int = 0) -> bytes:
    """Depth as 16-bit PNG of so many metres a unit; what is infinite has the value `far`."""
    return encode_png(np.where(np.isinf(depth), far, np.round(depth / scale)).astype(np.uint16))


def npy(values: np.ndarray) -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, values)
    return buffer.getvalue()


def tiff(values: np.ndarray, path: Path) -> None:
    spec = oiio.ImageSpec(values.shape[1], values.shape[0], 1, "float")
    path.parent.mkdir(parents=True, exist_ok=True)
    writer = oiio.ImageOutput.create(str(path))
    assert writer.open(str(path), spec)
    assert writer.write_image(values.astype(np.float32)[..., None])
    writer.close()


def exr(channels: dict[str, np.ndarray]) -> bytes:
    buffer = io.BytesIO()
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, channels).write(buffer)
    return buffer.getvalue()


def rgba(image: np.ndarray, alpha: int = 255) -> bytes:
    """RGB with an alpha channel, as CARLA saves it."""
    import isal.isal_zlib

    pixels = np.dstack([image, np.full(image.shape[:2], alpha, np.uint8)])
    rows = np.concatenate([np.zeros((len(pixels), 1), np.uint8), pixels.reshape(len(pixels), -1)], axis=1)
    return assemble_png(image.shape[1], image.shape[0], 8, RGBA, isal.isal_zlib.compress(rows.tobytes(), 1))


def carla_code(depth: np.ndarray) -> np.ndarray:
    """Depth in 24 bits of red, green and blue, up to 1 km."""
    values = np.round(np.minimum(depth, 1000) / 1000 * (2**24 - 1)).astype(np.int64)
    return np.stack([values & 255, values >> 8 & 255, values >> 16], axis=-1).astype(np.uint8)


def cityscapes(root: Path) -> None:
    stereo_frames.write(root / "cityscapes", stereo_frames.NAMES[0], stereo_frames.content(0))


def kitti(root: Path) -> None:
    """One drive of the depth set beside its raw data: image 0 has no ground truth, as in KITTI."""
    date, drive = "2011_09_26", "2011_09_26_drive_0001_sync"
    for number in range(2):
        image, depth = street(number)
        write_bytes(root / f"kitti/{date}/{drive}/image_02/data/{number:010d}.png", encode_png(image))
        depth[:, ::2] = np.inf  # a laser scanner sees no sky, and not each column
        if number:
            path = root / f"kitti/train/{drive}/proj_depth/groundtruth/image_02/{number:010d}.png"
            write_bytes(path, png16(depth, 1 / 256))
    text = "calib_time: 09-Jan-2012 13:57:47\ncorner_dist: 9.950000e-02\n"
    for camera, shift in ((2, 2.0), (3, -21.7)):
        text += f"S_rect_0{camera}: {COLUMNS:e} {ROWS:e}\nP_rect_0{camera}: {FX} 0 20 {shift} 0 {FX} 12 0 0 0 1 0\n"
    write_text(root / f"kitti/{date}/calib_cam_to_cam.txt", text)


def kitti_2015(root: Path) -> None:
    image, depth = street()
    write_bytes(root / "kitti/training/image_2/000000_10.png", encode_png(image))
    write_bytes(root / "kitti/training/disp_occ_0/000000_10.png", png16(FX * 0.54 / depth, 1 / 256))
    calibration = f"P_rect_02: {FX} 0 20 0 0 {FX} 12 0 0 0 1 0\nP_rect_03: {FX} 0 20 {-FX * 0.54} 0 {FX} 12 0 0 0 1 0\n"
    write_text(root / "kitti/training/calib_cam_to_cam/000000.txt", calibration)


def vkitti(root: Path) -> None:
    for variation in ("clone", "fog"):
        place, lines = root / f"vkitti/Scene01/{variation}", "frame cameraID K[0,0] K[1,1] K[0,2] K[1,2]\n"
        for number in range(2):
            image, depth = street(number)
            write_bytes(place / f"frames/rgb/Camera_0/rgb_{number:05d}.jpg", encode_jpeg(image))
            write_bytes(place / f"frames/depth/Camera_0/depth_{number:05d}.png", png16(depth, 0.01, 65535))
            lines += f"{number} 0 {FX} {FX} 20 12\n"
        write_text(place / "intrinsic.txt", lines)


def carla(root: Path) -> None:
    for camera in ("", "_left"):
        image, depth = street()
        write_bytes(root / f"carla/run1/rgb{camera}/000042.png", rgba(image))
        write_bytes(root / f"carla/run1/depth{camera}/000042.png", rgba(carla_code(depth)))


def synscapes(root: Path) -> None:
    fog_frames.write_frames(root / "synscapes", 2)


def nuscenes(root: Path) -> None:
    for number, camera in enumerate(("CAM_FRONT", "CAM_BACK")):
        image, depth = street(number)
        write_bytes(root / f"samples/{camera}/n015-{number}.jpg", encode_jpeg(image))
        write_bytes(root / f"depth/{camera}/n015-{number}.npy", npy(depth.astype(np.float32)))
        matrix = {"camera_intrinsic": [[FX, 0.0, 20.0], [0.0, FX, 12.0], [0.0, 0.0, 1.0]], "rotation": [1.0, 0, 0, 0]}
        write_text(root / f"calibration/{camera}.json", json.dumps(matrix))


def phone(root: Path) -> None:
    image, depth = street()
    depth = np.minimum(depth / 10, 5)
    depth[8:10, 10:14] = np.inf  # a hole
    write_bytes(root / "photo.jpg", encode_jpeg(image))
    write_bytes(root / "photo_depth.png", png16(depth, 0.001))


def drone(root: Path) -> None:
    image, depth = street()
    write_bytes(root / "drone/a.jpg", encode_jpeg(image))
    tiff(np.minimum(depth, 9000), root / "drone_depth/a.tif")


def matlab(root: Path) -> None:
    from scipy.io import savemat

    image, depth = street()
    buffer = io.BytesIO()
    savemat(buffer, {"depths": np.minimum(depth, 9).astype(np.float32), "ids": np.zeros(SIZE, np.uint8)})
    write_bytes(root / "indoor/1.png", encode_png(image))
    write_bytes(root / "indoor_depth/1.mat", buffer.getvalue())


def disparity(root: Path) -> None:
    image, depth = street()
    write_bytes(root / "left/a.png", encode_png(image))
    write_bytes(root / "disparity/a.png", png16(721.5 * 0.54 / depth, 1 / 256))


def channel(root: Path) -> None:
    image, depth = street()
    layers = {"depth.V": depth.astype(np.float32), "R": depth.astype(np.float16), "object": np.ones(SIZE, np.uint32)}
    write_bytes(root / "render/0001_rgb.png", encode_png(image))
    write_bytes(root / "render/0001_layers.exr", exr(layers))
    write_text(root / "camera.json", json.dumps(PLAIN))


def nested(root: Path) -> None:
    for number, place in enumerate(("monday/front/1", "tuesday/2")):
        image, depth = street(number)
        write_bytes(root / f"drives/{place}_rgb.png", encode_png(image))
        write_bytes(root / f"drives/{place}_depth.png", png16(np.minimum(depth, 600), 0.01))


def maps(root: Path) -> None:
    image, depth = street()
    stem, beta = "train/aachen/aachen_000000_000019_leftImg8bit", 0.01
    t = np.floor(255 * np.exp(-beta * depth) + 0.5).astype(np.uint8)
    write_bytes(root / f"leftImg8bit/{stem}.png", encode_png(image))
    write_bytes(root / f"leftImg8bit_transmittance/{stem}_transmittance_beta_0.01.png", encode_png(t))


RECIPES: dict[str, tuple[Callable[[Path], None], int]] = {
    "--layout cityscapes": (cityscapes, 1), "--layout kitti": (kitti, 1), "--layout vkitti": (vkitti, 2),
    "--layout carla": (carla, 2), "--layout synscapes": (synscapes, 4), "samples/": (nuscenes, 2),
    "photo.jpg": (phone, 1), "--depth-is ray": (drone, 1), "indoor_depth": (matlab, 1), "--baseline": (disparity, 1),
    "render/": (channel, 1), "drives/": (nested, 2), "--transmittance-map": (maps, 1),
}  # fmt: skip
"""By a part of its command: what makes the files of a recipe, and how many foggy images it gives."""
