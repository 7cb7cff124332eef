"""Frames of one's own: which files the command line names, what their depth means, and where their cameras are."""

import argparse
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import Any

from foggy_synscapes.depth.decoding import CODES, DISPARITY, MEANINGS, METRES, PLAIN, PLANAR, RAY, Encoding
from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.frames import cameras, patterns
from foggy_synscapes.frames.finding import IMAGES, order, parse_ids
from foggy_synscapes.frames.folders import Job
from foggy_synscapes.frames.given import ANSWERS, HOMOGENEOUS, JPEG, PNG, REFUSE, GivenFrame, GivenJob, MapJob
from foggy_synscapes.io.depth_files import FORMATS, known
from foggy_synscapes.io.pictures import QUALITY

CAMERAS = (".json", ".txt")
OPTIONS = (
    "depth_scale", "depth_offset", "depth_is", "depth_code", "depth_channel", "depth_far", "missing", "fov",
    "intrinsics", "baseline", "format", "quality", "transmittance_map",
)  # fmt: skip
"""What only frames of any origin take."""


def arguments(parser: argparse.ArgumentParser, images: bool = True) -> None:
    """Add the options that say what depth means, and of which camera it is.

    images : those of foggy images that are written as well, and of maps in the place of depth
    """
    depth = parser.add_argument_group(
        "depth", f"what the files of --depth hold; read are {known()}. A value v means (v - offset) x scale"
    )
    depth.add_argument(
        "--depth-scale",
        metavar="METRES",
        help="per stored unit, e.g. 0.001 (millimetres), 0.01, 1/256 (KITTI); of disparity: pixels per unit "
        "(needed for whole numbers; floating point is in metres, or pixels, without it)",
    )
    depth.add_argument("--depth-offset", type=float, metavar="UNITS", help="stored value of 0 (default: 0)")
    depth.add_argument(
        "--depth-is",
        choices=MEANINGS,
        help=f"metres to the image plane, metres along the ray, or pixels between both views (default: {PLANAR})",
    )
    depth.add_argument("--depth-code", choices=CODES, help=f"rgb24: 24 bits in red, green, blue, as CARLA ({PLAIN})")
    depth.add_argument("--depth-channel", metavar="NAME", help="channel of an EXR (default: Z), array of .npz or .mat")
    depth.add_argument(
        "--depth-far", type=float, metavar="UNITS", help="stored value from which on it is infinitely far"
    )
    depth.add_argument(
        "--missing",
        choices=ANSWERS,
        help="pixels whose depth is 0, negative or not a number: refuse the frame, take them for infinitely far, or "
        f"complete them from the image and the depth around (default: {REFUSE})",
    )
    camera = parser.add_argument_group("camera", "in the place of --camera")
    camera.add_argument("--fov", type=float, metavar="DEGREES", help="horizontal angle of view of all frames")
    camera.add_argument(
        "--intrinsics", metavar="FX,FY,U0,V0", help="focal lengths and principal point in pixels, of all"
    )
    camera.add_argument("--baseline", type=float, metavar="METRES", help="between both views, for disparity")
    if not images:
        parser.set_defaults(transmittance_map=None, format=None, quality=None)
        return
    depth.add_argument(
        "--transmittance-map",
        metavar="PATH",
        help="in the place of --depth and a camera: maps of transmittance at --beta, 8 or 16 bits, or from 0 to 1",
    )
    written = parser.add_argument_group("images")
    written.add_argument("--format", choices=(PNG, JPEG), help=f"of foggy images (default: {PNG})")
    written.add_argument("--quality", type=int, metavar="Q", help=f"of JPEG, 1 to 100 (default: {QUALITY})")


def refuse_options(args: argparse.Namespace, taken: tuple[str, ...] = ()) -> None:
    """Raise UsageError where options for frames of any origin are given with other ones."""
    for name in OPTIONS:
        if getattr(args, name, None) is not None and name not in taken:
            raise UsageError(f"--{name.replace('_', '-')}: goes with --rgb, not with --synscapes or this --layout")


def encoding(args: argparse.Namespace, preset: Encoding = METRES) -> Encoding:
    """What depth files hold: a preset, where the command line says nothing else; UsageError if that makes no sense."""
    said = {
        "scale": None if args.depth_scale is None else _scale(args.depth_scale),
        "offset": args.depth_offset,
        "meaning": args.depth_is,
        "code": args.depth_code,
        "far": args.depth_far,
    }
    try:
        return replace(preset, **{name: value for name, value in said.items() if value is not None})
    except ValueError as error:
        raise UsageError(f"depth: {error}") from None


def settings(args: argparse.Namespace, preset: Encoding = METRES, missing: str = REFUSE) -> dict[str, Any]:
    """What `GivenJob` has beside `Job`; UsageError if options make no sense together."""
    if args.fov is not None and args.intrinsics is not None:
        raise UsageError("--fov and --intrinsics: give one of them")
    quality = QUALITY if args.quality is None else args.quality
    if not 1 <= quality <= 100:
        raise UsageError(f"--quality {quality}: expected 1 to 100")
    if args.quality is not None and args.format != JPEG:
        raise UsageError(f"--quality: goes with --format {JPEG}")
    if args.baseline is not None and not args.baseline > 0:
        raise UsageError(f"--baseline {args.baseline}: expected metres above 0")
    return {
        "encoding": encoding(args, preset),
        "channel": args.depth_channel or "",
        "missing": args.missing or missing,
        "intrinsics": _intrinsics(args),
        "baseline": args.baseline,
        "ending": args.format or PNG,
        "quality": quality,
    }


def frames(args: argparse.Namespace, job: Job) -> tuple[list[GivenFrame], GivenJob]:
    """Frames that the command line names, and what is to be made of each.

    Raises UsageError where the command line makes no sense, FoggyError where there is no frame.
    """
    more = settings(args)
    if args.transmittance_map is not None:
        if args.depth is not None or args.camera is not None or len(job.betas) != 1 or job.transmittance:
            raise UsageError(
                "--transmittance-map: goes with --rgb and the one --beta that the maps are of, without --depth, "
                "--camera and --transmittance"
            )
        if job.model != HOMOGENEOUS:
            raise UsageError(f"--model {job.model}: a map of transmittance says already how dense the fog is")
        return found(args.rgb, args.transmittance_map, None, args.ids, args.out), MapJob(**vars(job), **more)
    made = GivenJob(**vars(job), **more)
    stated = [name for name in ("camera", "fov", "intrinsics") if getattr(args, name) is not None]
    if len(stated) + args.camera_in_depth > 1:
        raise UsageError("--camera, --camera-in-depth, --fov and --intrinsics: give one of them")
    if args.depth is None or not (stated or args.camera_in_depth or made.encoding.meaning == RAY):
        raise UsageError(
            "give --synscapes ROOT, or --rgb DIR, --depth DIR and --camera FILE (or --camera-in-depth, --fov, "
            "--intrinsics, or --depth-is ray, which needs none)"
        )
    if made.encoding.meaning == DISPARITY and made.baseline is None and args.camera is None:
        raise UsageError(
            "--depth-is disparity: give --baseline, the metres between both views, or a camera file with it"
        )
    every = found(args.rgb, args.depth, args.camera, args.ids, args.out)
    return [replace(each, in_depth=args.camera_in_depth) for each in every], made


def found(rgb: str, depth: str, camera: str | None, ids: str | None, out: Path) -> list[GivenFrame]:
    """Frames whose images, depth and cameras patterns, folders or files name, in the order of their ids.

    Raises UsageError if a folder is missing or patterns do not fit, FoggyError if there is no frame, or none has depth.
    """
    images, wanted = _images(rgb, out), None if ids is None else set(parse_ids(ids))
    pattern, where = patterns.Pattern(rgb), _Place(depth, "--depth")
    place = None if camera is None else _Place(camera, "--camera")
    every: dict[str, GivenFrame] = {}
    for path, words in images:
        try:
            name = path.relative_to(_base(rgb, pattern)).with_suffix("").as_posix()
            name.encode("utf-8")
        except UnicodeEncodeError as error:
            raise FoggyError(f"{str(path)!r}: its name is not UTF-8, as the tables are. Rename it.") from error
        if wanted is not None and not (path.stem.isdecimal() and int(path.stem) in wanted):
            continue
        metres = where.of(name, words, tuple(FORMATS), path)
        own = metres if place is None else place.of(name, words, CAMERAS, path)
        frame = GivenFrame(name, path, metres, own)
        if every.setdefault(name, frame) is not frame:
            raise FoggyError(f"{path}: would give the same file names as {every[name].rgb}. Rename one of them.")
    if not every:
        odd = sorted(path for path in Path(rgb).rglob("*") if path.suffix.lower() in IMAGES and not path.is_file())
        said = f"; {odd[0]} is no plain file" if odd else ""
        raise FoggyError(f"{rgb}: holds no image ({', '.join(IMAGES)}){' with these --ids' if ids else ''}{said}")
    if not any(frame.depth.exists() for frame in every.values()):
        first = next(iter(every.values()))
        raise FoggyError(
            f"{depth}: holds depth of none of {len(every)} images; of {first.rgb} it would be {first.depth}. Read are "
            f"{known()}. Where names differ, give patterns: --rgb 'A/*_rgb.png' --depth 'B/*_depth.npy'"
        )
    return sorted(every.values(), key=lambda frame: order(frame.id))


class _Place:
    """Where the depth or the camera of each image is: a folder with files of the same names, a pattern, or one file."""

    def __init__(self, text: str, option: str) -> None:
        self.option, self.pattern = option, patterns.Pattern(text)
        self.folder = not self.pattern.wildcards and self.pattern.base.is_dir()
        if not (self.folder or self.pattern.wildcards or self.pattern.base.is_file()):
            raise UsageError(f"{text}: no such folder or file ({option})")

    def of(self, name: str, words: tuple[str, ...], endings: tuple[str, ...], image: Path) -> Path:
        """The file that belongs to an image; UsageError if a pattern has too many wildcards."""
        if not self.folder:
            several = self.pattern.wildcards
            if several > len(words) or (several != len(words) and self.option == "--depth"):
                raise UsageError(
                    f"{self.option} {self.pattern.text}: has {several} wildcards, and --rgb {len(words)}; what each "
                    "stands for in --rgb, it stands for here"
                )
            return self.pattern.filled(words)
        there = [self.pattern.base / f"{name}{ending}" for ending in endings]
        some = [path for path in there if path.exists() and path != image]
        if len(some) > 1:
            raise FoggyError(f"{some[0]} and {some[1]}: which is it? Name them by a pattern: '{some[0].parent}/*.npy'")
        if some:
            return some[0]
        # Missing is a file that ends as the others do.
        return next((path for path in there if path.suffix in self.endings and path != image), there[0])

    @cached_property
    def endings(self) -> set[str]:
        """Endings of the files in the folder."""
        return {path.suffix for path in self.pattern.base.rglob("*")}


def _images(rgb: str, out: Path) -> list[tuple[Path, tuple[str, ...]]]:
    """Images, each with what the wildcards stand for; of a folder its own, or where it has none those below it."""
    if patterns.is_pattern(rgb) or not Path(rgb).is_dir():
        images = patterns.Pattern(rgb).files()
        if not images and not patterns.is_pattern(rgb):
            raise UsageError(f"{rgb}: no such folder or file (--rgb)")
    else:
        for deeper in ("*", "**/*"):
            every = patterns.Pattern(f"{rgb}/{deeper}").files()
            images = [(path, ()) for path, _ in every if path.suffix.lower() in IMAGES]
            if images:
                break
    made = out.resolve()
    return [(path, words) for path, words in images if made not in path.resolve().parents]


def _base(rgb: str, pattern: patterns.Pattern) -> Path:
    """The folder below which ids name images."""
    return pattern.base if pattern.wildcards or Path(rgb).is_dir() else pattern.base.parent


def _scale(text: str) -> float:
    try:
        scale = float(Fraction(text.strip()))
    except (ValueError, ZeroDivisionError, OverflowError):
        raise UsageError(f"--depth-scale {text}: expected metres per unit, e.g. 0.001 or 1/256") from None
    if not scale > 0:
        raise UsageError(f"--depth-scale {text}: expected metres per unit above 0, e.g. 0.001 or 1/256")
    return scale


def _intrinsics(args: argparse.Namespace) -> cameras.Intrinsics | float | None:
    if args.fov is not None:
        if not 0 < args.fov < 180:
            raise UsageError(f"--fov {args.fov}: expected degrees between 0 and 180")
        return float(args.fov)
    if args.intrinsics is None:
        return None
    try:
        numbers = [float(part) for part in args.intrinsics.split(",")]
        fx, fy, u0, v0 = numbers
    except ValueError:
        raise UsageError(
            f"--intrinsics {args.intrinsics}: expected FX,FY,U0,V0 in pixels, e.g. 720,720,640,360"
        ) from None
    return cameras.Intrinsics(fx, fy, u0, v0)
