"""CARLA: images in folders rgb*, depth in folders depth* beside them, in 24 bits of three colours up to 1 km.

Its recordings hold no camera; a camera of CARLA sees a horizontal angle of 90 degrees where nothing else is said.
Source of the code of depth: CARLA's documentation, sensors reference, depth camera.
"""

from foggy_synscapes.depth.decoding import HIGHEST, RGB24, Encoding
from foggy_synscapes.errors import UsageError
from foggy_synscapes.frames import own_frames
from foggy_synscapes.frames.finding import Frame
from foggy_synscapes.frames.folders import Job
from foggy_synscapes.frames.given import GivenJob
from foggy_synscapes.frames.layouts.layout import Layout, Request

FOV = 90.0
ENCODING = Encoding(scale=1000 / HIGHEST, code=RGB24, far=HIGHEST)


def fog(request: Request, job: Job) -> tuple[list[Frame], Job]:
    """Fog on what the cameras rgb* recorded, by the depth cameras of the same place; what is at 1 km is the sky."""
    if not request.root.is_dir():
        raise UsageError(f"{request.root}: no such folder (--root)")
    options = request.options
    more = own_frames.settings(options, ENCODING)
    if options.camera is None and more["intrinsics"] is None:
        more["intrinsics"] = FOV
    root = request.root
    images, depth = f"{root}/**/rgb*/*", f"{root}/**/depth*/*"
    return [*own_frames.found(images, depth, options.camera, options.ids, job.out)], GivenJob(**vars(job), **more)


LAYOUT = Layout(
    text="rgb*/NAME.png and depth*/NAME.png, angle of view 90 degrees without --fov",
    fog=fog,
    takes=("ids", "camera", "fov", "intrinsics", "missing", "format", "quality"),
)
