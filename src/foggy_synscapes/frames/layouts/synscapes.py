"""Synscapes, as `--synscapes ROOT` names it: numbered frames, exact depth, a camera for each."""

from foggy_synscapes.frames.finding import Frame, of_synscapes
from foggy_synscapes.frames.folders import Job
from foggy_synscapes.frames.layouts.layout import Layout, Request


def fog(request: Request, job: Job) -> tuple[list[Frame], Job]:
    """Fog on frames with exact depth, in the folders of the published script."""
    return of_synscapes(request.root, request.options.ids, None), job


LAYOUT = Layout(text="img/rgb, img/depth and meta", fog=fog, takes=("ids",))
