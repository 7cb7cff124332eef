"""What a layout offers: frames of a dataset as it unpacks, and fog on them under its published names."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from foggy_synscapes.frames.finding import Frame
from foggy_synscapes.frames.folders import Job


@dataclass(frozen=True)
class Request:
    """What the command line asks of a layout.

    root : folder of the dataset; splits : its parts, all where there is none; listed : file that names frames
    depth_from, refine : where depth comes from and how transmittance is refined; None: the layout's defaults
    seed : of random permutations, None: the published one
    """

    root: Path
    splits: Sequence[str] = ()
    listed: Path | None = None
    depth_from: str | None = None
    refine: str | None = None
    seed: int | None = None


@dataclass(frozen=True)
class Layout:
    """A dataset's folders.

    text : one line for the help
    fog : (request, what fog on plain folders would do) -> frames, and what is to be made of each
    complete : the same for depth, where the layout has none of its own

    Both raise UsageError where the request makes no sense, and FoggyError where there is no frame.
    """

    text: str
    fog: Callable[[Request, Job], tuple[list[Frame], Job]]
    complete: Callable[[Request, Job], tuple[list[Frame], Job]] | None = None
