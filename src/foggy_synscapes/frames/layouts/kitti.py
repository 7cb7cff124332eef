"""KITTI: depth of its depth set (ground truth or laser scanner), and disparity of its stereo set of 2015.

Depth and disparity are 16-bit PNG, 256 units a metre or a pixel, 0 where there is none. Most pixels have none, so they
are completed from the image unless `--missing` says otherwise.
Source: Uhrig et al., "Sparsity Invariant CNNs", 3DV 2017; Menze and Geiger, CVPR 2015; the development kits.
"""

from collections.abc import Callable
from pathlib import Path

from foggy_synscapes.depth.decoding import DISPARITY, Encoding
from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.frames import own_frames
from foggy_synscapes.frames.finding import Frame, order
from foggy_synscapes.frames.folders import Job
from foggy_synscapes.frames.given import COMPLETE, GivenFrame, GivenJob
from foggy_synscapes.frames.layouts.layout import Layout, Request

GROUND_TRUTH, VELODYNE, STEREO = "groundtruth", "velodyne_raw", "disparity"
UNITS = Encoding(scale=1 / 256)
DISPARITIES = Encoding(scale=1 / 256, meaning=DISPARITY)
DATE = 10  # letters of a drive's name, e.g. 2011_09_26_drive_0001_sync, that name the day and its calibration


def fog(request: Request, job: Job) -> tuple[list[Frame], Job]:
    """Fog on the images that have depth, in the folders of the depth files."""
    if not request.root.is_dir():
        raise UsageError(f"{request.root}: no such folder (--root)")
    if request.depth_from not in (None, *WAYS):
        raise UsageError(f"--depth-from {request.depth_from}: KITTI has depth from {', '.join(WAYS)}")
    for way in [request.depth_from] if request.depth_from else WAYS:
        found = WAYS[way](request.root)
        splits = {frame.id.split("/")[0] for frame in found}
        wanted = [frame for frame in found if not request.splits or frame.id.split("/")[0] in request.splits]
        if found and not wanted:
            raise UsageError(f"{request.root}: no depth of {', '.join(request.splits)}; there is {', '.join(splits)}")
        if wanted:
            encoding = DISPARITIES if way == STEREO else UNITS
            more = own_frames.settings(request.options, encoding, COMPLETE)
            return sorted(wanted, key=lambda frame: order(frame.id)), GivenJob(**vars(job), **more)
    raise FoggyError(
        f"{request.root}: no depth SPLIT/DRIVE/proj_depth/{{{GROUND_TRUTH},{VELODYNE}}}/image_0N/NAME.png, none in "
        "val_selection_cropped, and no disparity training/disp_occ_0/NAME.png"
    )


def _projected(root: Path, way: str) -> list[GivenFrame]:
    """The depth set: images are those of the raw data, unpacked beside it or into its folders."""
    frames = []
    for depth in root.glob(f"*/*/proj_depth/{way}/image_0[0-3]/*.png"):
        camera, drive = depth.parent.name, depth.parents[3]
        beside, own = root / drive.name[:DATE] / drive.name, drive
        folder = own if (own / camera).is_dir() else beside
        name = depth.relative_to(root).with_suffix("").as_posix()
        calibration = folder.parent / "calib_cam_to_cam.txt"
        frames.append(GivenFrame(name, folder / camera / "data" / depth.name, depth, calibration))
    return frames


def _selected(root: Path) -> list[GivenFrame]:
    """The thousand validation images of the depth set, cropped, each with a camera file."""
    frames, folder = [], root / "val_selection_cropped"
    for depth in folder.glob("groundtruth_depth/*.png"):
        stem = depth.stem.replace("_groundtruth_depth_", "_image_")
        rgb, camera = folder / "image" / f"{stem}.png", folder / "intrinsics" / f"{stem}.txt"
        frames.append(GivenFrame(rgb.relative_to(root).with_suffix("").as_posix(), rgb, depth, camera))
    return frames


def _stereo(root: Path) -> list[GivenFrame]:
    """The stereo set of 2015: of each pair of times the first, whose disparity is known."""
    frames, folder = [], root / "training"
    for depth in folder.glob("disp_occ_0/*_10.png"):
        rgb = folder / "image_2" / depth.name
        camera = folder / "calib_cam_to_cam" / f"{depth.stem.removesuffix('_10')}.txt"
        frames.append(GivenFrame(rgb.relative_to(root).with_suffix("").as_posix(), rgb, depth, camera))
    return frames


WAYS: dict[str, Callable[[Path], list[GivenFrame]]] = {
    GROUND_TRUTH: lambda root: _projected(root, GROUND_TRUTH) + _selected(root),
    VELODYNE: lambda root: _projected(root, VELODYNE),
    STEREO: _stereo,
}
"""Where depth comes from, in the order in which a folder is searched."""

LAYOUT = Layout(
    text="its depth set beside the raw data, or the stereo set of 2015; what has no depth is completed",
    fog=fog,
    takes=("split", "depth_from", "missing", "format", "quality"),
)
