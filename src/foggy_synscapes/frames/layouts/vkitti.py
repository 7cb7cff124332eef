"""Virtual KITTI 2: depth as 16-bit PNG in centimetres, of which the highest value is the sky; a camera for each frame.

Source: Cabon, Murray and Humenberger, "Virtual KITTI 2", 2020, and the dataset's description of its files.
"""

from pathlib import Path

from foggy_synscapes.depth.decoding import Encoding
from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.frames import own_frames
from foggy_synscapes.frames.finding import Frame
from foggy_synscapes.frames.folders import Job
from foggy_synscapes.frames.given import GivenFrame, GivenJob
from foggy_synscapes.frames.layouts.layout import Layout, Request

ENCODING = Encoding(scale=0.01, far=65535)
FOGGY = "fog"
"""Of a scene's variations the one that has fog already."""


def fog(request: Request, job: Job) -> tuple[list[Frame], Job]:
    """Fog on the variations of all scenes that `--split` names, e.g. clone; without it on all but `fog`."""
    scenes = sorted(path for path in request.root.glob("Scene*/*/frames") if path.is_dir())
    there = sorted({path.parent.name for path in scenes})
    if not scenes:
        raise UsageError(
            f"{request.root}: no SceneNN/VARIATION/frames; --root names the folder that holds Scene01, ..."
        )
    for split in request.splits:
        if split not in there:
            raise UsageError(f"{request.root}: no variation {split}; there are {', '.join(there)}")
    wanted = request.splits or [name for name in there if name != FOGGY]
    found = [frame for path in scenes if path.parent.name in wanted for frame in _frames(request.root, path)]
    if not found:
        raise FoggyError(f"{request.root}: no image frames/rgb/Camera_N/rgb_NNNNN.jpg of {', '.join(wanted)}")
    return [*found], GivenJob(**vars(job), **own_frames.settings(request.options, ENCODING))


def _frames(root: Path, folder: Path) -> list[GivenFrame]:
    """Frames below `frames` of a variation, all its cameras."""
    return [
        GivenFrame(
            id=path.relative_to(root).with_suffix("").as_posix(),
            rgb=path,
            depth=folder / "depth" / path.parent.name / f"depth_{path.stem.removeprefix('rgb_')}.png",
            camera=folder.parent / "intrinsic.txt",
        )
        for path in sorted(folder.glob("rgb/Camera_*/rgb_*.*"))
        if path.suffix in (".jpg", ".png")
    ]


LAYOUT = Layout(
    text="Virtual KITTI 2, SceneNN/VARIATION/frames; --split names variations",
    fog=fog,
    takes=("split", "missing", "format", "quality"),
)
