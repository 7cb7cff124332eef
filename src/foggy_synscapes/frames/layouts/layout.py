"""What a layout offers: frames of a dataset as it unpacks, and fog on them under its published names."""

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from foggy_synscapes.frames.finding import Frame
from foggy_synscapes.frames.folders import Job


@dataclass(frozen=True)
class Request:
    """What the command line asks of a layout.

    root : folder of the dataset; splits : its parts, all where there is none; listed : file that names frames
    depth_from, refine : where depth comes from and how transmittance is refined; None: the layout's defaults
    seed : of random permutations, None: the published one
    options : of the command line, out of those that the layout takes
    """

    root: Path
    splits: Sequence[str] = ()
    listed: Path | None = None
    depth_from: str | None = None
    refine: str | None = None
    seed: int | None = None
    options: argparse.Namespace = field(default_factory=argparse.Namespace)


@dataclass(frozen=True)
class Wanted:
    """A shard of foggy images on indexed frames.

    root : folder of the dataset; index : SHA-256 of its files by path
    completed : shard of depth; lights : three levels by frame, of those that are in the shard
    beta : 1/m; refine, geometry, level : how transmittance is refined, the rays, and the effort of PNG
    """

    root: Path
    index: Mapping[str, str]
    completed: Path
    lights: Mapping[str, tuple[int, int, int]]
    beta: str
    refine: str
    geometry: str
    level: int


Member = tuple[str, Callable[[], bytes]]
"""Name of a file in a shard, and what makes its content."""


@dataclass(frozen=True)
class Layout:
    """A dataset's folders.

    text : one line for the help
    fog : (request, what fog on plain folders would do) -> frames, and what is to be made of each
    complete : the same for depth, where the layout has none of its own
    members : foggy images for a shard, sorted by name; only of a layout whose depth is completed
    takes : options of the command line that it takes beside those of all, e.g. "split"

    The first two raise UsageError where the request makes no sense, and FoggyError where there is no frame.
    """

    text: str
    fog: Callable[[Request, Job], tuple[list[Frame], Job]]
    complete: Callable[[Request, Job], tuple[list[Frame], Job]] | None = None
    members: Callable[[Wanted], Iterator[Member]] | None = None
    takes: tuple[str, ...] = ()
