"""Frames of a dataset as it unpacks, named on the command line by its layout."""

import argparse
from pathlib import Path

from foggy_synscapes.errors import UsageError
from foggy_synscapes.frames.finding import Frame
from foggy_synscapes.frames.folders import Job
from foggy_synscapes.frames.layouts import LAYOUTS, Request
from foggy_synscapes.frames.own_frames import OPTIONS

OTHERS = ("synscapes", "rgb", "depth", "camera", "camera_in_depth", "ids")
"""Options that name frames in another way."""
OWN = ("split", "list", "depth_from", "refine", "seed")
"""Options of layouts, of which each takes some."""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options that name frames by a layout."""
    names = LAYOUTS.names()
    group = parser.add_argument_group("dataset", "frames of a dataset as it unpacks")
    about = "; ".join(f"{name}: {LAYOUTS[name].text}" for name in names)
    group.add_argument("--layout", choices=names, help=f"of the dataset ({about})")
    group.add_argument("--root", type=Path, metavar="DIR", help="folder of the dataset, e.g. the one with leftImg8bit")
    group.add_argument(
        "--split", action="append", metavar="NAME", help="part of it, e.g. train; several: --split again (default: all)"
    )
    group.add_argument(
        "--list", type=Path, metavar="FILE", help="only the frames that it names, one a line: SPLIT/CITY/NAME"
    )
    group.add_argument(
        "--depth-from",
        metavar="WAY",
        help="where depth comes from (cityscapes: stereo; kitti: groundtruth, velodyne_raw or disparity)",
    )
    group.add_argument(
        "--refine",
        metavar="WAY",
        help="transmittance: guided by the image (default), or bilateral, by the image and its instance ids",
    )
    group.add_argument(
        "--seed", type=int, metavar="N", help="of the random choices in depth from stereo (default: the published one)"
    )


def frames(args: argparse.Namespace, job: Job, depth: bool = False) -> tuple[list[Frame], Job]:
    """Frames that the command line asks for, and what is to be made of each: fog as `job` says, or depth.

    Raises UsageError where the command line makes no sense, FoggyError where there is no frame.
    """
    layout = LAYOUTS[args.layout]
    for name in (*OTHERS, *OWN, *OPTIONS):
        if getattr(args, name, None) not in (None, False) and name not in layout.takes:
            reason = "takes no such option" if name in OWN else "names frames, depth and cameras itself"
            raise UsageError(f"--{name.replace('_', '-')}: --layout {args.layout} {reason}")
    if args.root is None:
        raise UsageError(f"--layout {args.layout}: give --root, the folder of the dataset")
    make = layout.complete if depth else layout.fog
    if make is None:
        raise UsageError(f"--layout {args.layout}: has depth of its own, there is nothing to complete")
    wanted = Request(args.root, args.split or (), args.list, args.depth_from, args.refine, args.seed, args)
    return make(wanted, job)


def refuse_without_layout(args: argparse.Namespace) -> None:
    """Raise UsageError where options of a layout are given without one."""
    for name in ("root", *OWN):
        if getattr(args, name) is not None:
            raise UsageError(f"--{name.replace('_', '-')}: goes with --layout, e.g. --layout cityscapes")
