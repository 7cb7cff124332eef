"""Fog on any frames, without a pipeline: what a folder of foggy images was made with, and what is missing there."""

import argparse
import sys
import time
from contextlib import closing
from dataclasses import replace
from pathlib import Path

from foggy_synscapes import __version__
from foggy_synscapes.betas import beta_name
from foggy_synscapes.datasets.synscapes import read_camera
from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.fog.models import MODELS, spelt
from foggy_synscapes.fog.optics import (
    attenuation,
    denser_than_usual,
    lighter_than_fog,
    meteorological_optical_range,
)  # fmt: skip
from foggy_synscapes.frames import by_layout, folders, journal, own_frames, settings
from foggy_synscapes.frames.finding import Frame, of_synscapes, order
from foggy_synscapes.frames.given import GivenFrame
from foggy_synscapes.io import lock
from foggy_synscapes.io.atomic import remove_leftovers
from foggy_synscapes.io.checksums import Checksums
from foggy_synscapes.io.hashing import sha256
from foggy_synscapes.io.progress import progress
from foggy_synscapes.io.tables import write_csv

HOMOGENEOUS = "homogeneous"
COLUMNS = ("id", "red", "green", "blue", "row", "column")
SHOWN = 10  # errors and warnings printed in full


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of fog on any frames."""
    by_layout.arguments(parser)
    own_frames.arguments(parser)
    frames = parser.add_argument_group("frames", "foggy images of any frames; no params file is needed")
    frames.add_argument("--synscapes", type=Path, metavar="ROOT", help="folder with img/rgb, img/depth and meta")
    frames.add_argument(
        "--rgb", metavar="PATH", help="or: 8-bit images, a folder, a pattern such as 'cam*/*.png', a file"
    )
    frames.add_argument(
        "--depth",
        metavar="PATH",
        help="and their depth: a folder with the same names, a pattern with as many *, a file",
    )
    frames.add_argument(
        "--beta", action="append", metavar="B", help="attenuation coefficient in 1/m, e.g. 0.005; several: --beta again"
    )
    frames.add_argument(
        "--visibility", action="append", metavar="METRES", help="the same by visibility: 150 is --beta 0.01997"
    )
    frames.add_argument(
        "--out", type=Path, metavar="DIR", help="where to write beta_B/foggy_img/*.png and airlight.csv"
    )
    frames.add_argument("--ids", metavar="LIST", help="frame numbers, e.g. 1-500 or 1,5,9-12 (default: all)")
    frames.add_argument(
        "--camera",
        metavar="PATH",
        help="one camera file for all; with --rgb also a folder or a pattern, one for each frame or folder of frames",
    )
    frames.add_argument(
        "--camera-in-depth",
        action="store_true",
        help="take each camera from the header of its depth file, as Synscapes has it",
    )
    frames.add_argument(
        "--geometry",
        choices=("paper", "exact"),
        default="paper",
        help="distance along the ray as the published code has it, or from fx, fy and pixel centres (default: paper)",
    )
    frames.add_argument(
        "--model",
        type=_model,
        metavar="MODEL",
        help="of fog, NAME or NAME:KEY=VALUE,... (default: homogeneous). "
        + "; ".join(f"{name}: {MODELS[name].text}" for name in MODELS),
    )
    frames.add_argument("--transmittance", action="store_true", help="write 8-bit transmittance maps as well")
    frames.add_argument(
        "--blue-airlight",
        choices=("keep", "drop", "grey"),
        default="keep",
        help="where the atmospheric light is that of a blue sky: keep it, leave the frame out, or make it grey",
    )
    frames.add_argument(
        "--png-level",
        type=int,
        choices=range(4),
        default=0,
        help="0: codes for photographs, fastest (default); 1 to 3: effort of deflate",
    )
    frames.add_argument(
        "--checksums", type=Path, metavar="FILE", help="SHA-256 of all inputs, as sha256sum writes them: checked first"
    )
    frames.add_argument("--jobs", type=int, default=1, metavar="N", help="processes (default: 1)")
    frames.add_argument("--keep-going", action="store_true", help="finish the other frames where one is broken")


def _model(text: str) -> str:
    """A fog model as it is spelt; argparse names what is wrong with it."""
    try:
        return spelt(text)
    except (FoggyError, ValueError) as error:
        raise argparse.ArgumentTypeError(str(error)) from error


def run(args: argparse.Namespace, code: str) -> None:
    """Fog the frames that the command line names; `code` is the digest of the code that renders."""
    typed = betas_of(args.beta or [])
    betas = betas_of([*(args.beta or []), *of_visibility(args.visibility or [])])
    if args.out is None or not betas:
        named = args.rgb or args.synscapes or args.layout
        lacking = {
            "--rgb, --depth and --camera (or --synscapes, --layout, or --shard)": named,
            "--beta or --visibility": betas,
            "--out": args.out,
        }
        raise UsageError(f"give {'; '.join(option for option, value in lacking.items() if not value)}")
    for beta in betas:
        if float(beta):
            print(f"fog: beta {beta} / m is a visibility of {meteorological_optical_range(float(beta)):,.3g} m")
        # Who says metres has not slipped a digit of 1/m.
        asked = denser_than_usual(float(beta)) if beta in typed else None
        for warning in filter(None, (lighter_than_fog(float(beta)), asked)):
            print(f"warning: {warning}", file=sys.stderr)
    options = args.geometry, args.transmittance, args.png_level, args.blue_airlight, args.model or HOMOGENEOUS
    job, camera = folders.Job(args.out, betas, *options), None
    found: list[Frame]
    if args.layout is not None:
        found, job = by_layout.frames(args, job)
    else:
        by_layout.refuse_without_layout(args)
        if args.camera and args.camera_in_depth:
            raise UsageError("--camera and --camera-in-depth: give one of them")
        if args.synscapes is not None and not (args.rgb or args.depth):
            own_frames.refuse_options(args)
            camera = Path(args.camera) if args.camera else None
            if camera is not None:
                read_camera(camera)  # one camera for all frames: its errors are said once
            found = of_synscapes(args.synscapes, args.ids, camera, args.camera_in_depth)
        elif args.rgb and args.synscapes is None:
            given, job = own_frames.frames(args, job)
            found = [*given]
        else:
            raise UsageError(
                "give --synscapes ROOT, or --rgb DIR, --depth DIR and --camera FILE (or --camera-in-depth)"
            )
    fog(checked(found, args.checksums), job, code, camera, jobs=args.jobs, keep_going=args.keep_going)


def of_visibility(texts: list[str]) -> list[str]:
    """Betas in 1/m of visibilities in metres, to four digits.

    >>> of_visibility(["150"])
    ['0.01997']

    Raises UsageError if one is no number above 0.
    """
    found = []
    for text in texts:
        try:
            found.append(f"{attenuation(float(text)):.4g}")
        except ValueError:
            raise UsageError(f"--visibility {text}: expected metres above 0, e.g. 150") from None
    return found


def checked(frames: list[Frame], checksums: Path | None) -> list[Frame]:
    """Frames whose files must be as a list of SHA-256 says, where there is one."""
    if checksums is None:
        return frames
    listed = Checksums(checksums)
    return [replace(each, checksums=[listed.of(path) for path in each.files()]) for each in frames]


def betas_of(texts: list[str]) -> list[str]:
    """Betas as folders spell them; 0 is the clear image."""
    betas: dict[str, str] = {}
    for text in texts:
        try:
            name = "0" if float(text) == 0 else beta_name(text)
        except ValueError as error:
            reason = str(error) if "beta" in str(error) else f"beta {text!r} is not a number of 1/m, e.g. 0.005"
            raise UsageError(f"--beta: {reason}") from None
        if name in betas:
            raise UsageError(f"--beta {betas[name]} and --beta {text} name the same folder beta_{name}: give it once")
        betas[name] = text
    return list(betas)


def fog(
    frames: list[Frame],
    job: folders.Job,
    code: str,
    camera: Path | None = None,
    jobs: int = 1,
    keep_going: bool = False,
    word: str = "fog",
) -> None:
    """Write what `job` makes of frames, and the table of their atmospheric light, below `job.out`.

    Images that an earlier run finished with the same settings are kept, if they and their inputs have the content that
    they had then, wherever they lie. Another run may be at work on other frames in the same folder.

    word : of the command, for messages
    code : digest of the code that renders; camera : file of the camera, where all frames have the same

    Raises
    ------
    UsageError
        If `jobs` is below 1.
    FoggyError
        Naming the broken frames; with `keep_going` after all others are finished.
    """
    if jobs < 1:
        raise UsageError(f"--jobs {jobs}: expected 1 or more")
    table, job = job.out / "airlight.csv", replace(job, stated=_settings(job, frames, code, camera))
    with lock.of_folder(job.out):
        own = {path.name for frame in frames for paths in job.paths(frame) for path in paths}
        remove_leftovers(job.out, {*own, settings.NAME, table.name})
        settings.check(job.out, job.stated, job.made)
        known = journal.begin(job.out)
    found: dict[str, folders.Made] = {}
    started, total = time.perf_counter(), folders.Done("")
    broken: dict[str, str] = {}
    blue: list[str] = []
    with closing(folders.fog_frames(frames, job, jobs, known)) as results:
        for done in progress(results, word, total=len(frames), unit="frame"):
            if done.error:
                broken[done.id] = done.error
                if keep_going:
                    continue
                break
            if done.frame != known.get(done.id):
                journal.append(job.out, done.id, done.frame)
            found[done.id] = done.frame
            blue += [done.id] if done.blue else []
            total.add(done)
    with lock.of_folder(job.out):
        rows = journal.finish(job.out, found)
        lights = [(frame, *rows[frame].light) for frame in rows if frame not in broken]
        write_csv(table, COLUMNS, sorted(lights, key=lambda row: order(row[0])))
    for warning in _shortened(total.warnings):
        print(f"warning: {warning}", file=sys.stderr)
    if blue:
        kept = "as of a clear sky, and used as it is (otherwise: --blue-airlight grey or drop)"
        answer = {"keep": kept, "drop": "left out", "grey": "made grey"}[job.treatment]
        print(f"{word}: blue atmospheric light in {len(blue)} frames, {answer}: {', '.join(_shortened(blue))}")
    if total.again:
        print(f"{word}: {total.again} images in {job.out} were not as these inputs make them, and were made again")
    seconds = time.perf_counter() - started
    print(
        f"{word}: {len(found)} frames, {len(job.betas)} betas, {total.made} images made, {total.kept} kept, "
        f"{seconds:.1f} s, {total.made / seconds:.1f} images/s, {total.bytes / 1e6:.1f} MB in {job.out}"
    )
    if broken:
        end = f"{len(broken)} of {len(frames)} frames broken"
        if not keep_going:
            again = "Correct it and give the same command again; --keep-going passes over such frames"
            end = f"stopped at this one of {len(frames)} frames. {again}"
        raise FoggyError("\n".join([*broken.values(), end]))


def _camera(frames: list[Frame], camera: Path | None) -> str:
    """Where cameras come from; one camera for all counts with its content."""
    if any(isinstance(frame, GivenFrame) for frame in frames):
        return "of each frame, or as the settings say"  # what each is made of is noted with its images
    if camera is not None:
        return f"one file, {sha256(camera)[:16]}"
    return "depth files" if all(frame.camera == frame.depth for frame in frames) else "meta files"


def _settings(job: folders.Job, frames: list[Frame], code: str, camera: Path | None) -> str:
    """What the folder has to state, so that it holds no images of different settings or versions of the code."""
    return settings.text(
        {"camera": _camera(frames, camera), "code": code[:16], **job.settings(), "foggy_synscapes": __version__}
    )


def _shortened(lines: list[str]) -> list[str]:
    return lines if len(lines) <= SHOWN else [*lines[:SHOWN], f"and {len(lines) - SHOWN} more"]
