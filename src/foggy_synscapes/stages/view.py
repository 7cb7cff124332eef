"""view: pages to look at, for any browser: one frame in fog of any density, or the predictions of a finished run."""

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from foggy_synscapes.depth.decoding import RAY
from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.fog.airlight import Airlight
from foggy_synscapes.fog.geometry import GEOMETRIES
from foggy_synscapes.frames import own_frames
from foggy_synscapes.frames.given import GivenFrame, GivenJob
from foggy_synscapes.frames.rendering import KEEP, airlight_of
from foggy_synscapes.frames.standalone import of_visibility
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.view.frame import frame_page

if TYPE_CHECKING:
    from foggy_synscapes.figures.sources import Sources
    from foggy_synscapes.params import Params
    from foggy_synscapes.view.predictions import Row, Shown

HELP = "Write a page to look at, one HTML file that needs no network: the fog of a frame, or the predictions of a run."
QUALITY = 88  # of JPEG: a street scene of 2048 x 1024 pixels takes a tenth of its PNG
FRAME = ("rgb", "depth", "out")


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this step."""
    frame = parser.add_argument_group("a frame", "its fog at any density; no params file is needed")
    frame.add_argument("--rgb", type=Path, metavar="FILE", help="8-bit image")
    frame.add_argument("--depth", type=Path, metavar="FILE", help="its depth")
    frame.add_argument(
        "--camera", type=Path, metavar="FILE", help="its camera; or its depth file, if the header has one"
    )
    frame.add_argument("--out", type=Path, metavar="FILE", help="where to write the page, e.g. frame.html")
    density = frame.add_mutually_exclusive_group()
    density.add_argument("--beta", type=float, metavar="B", help="1/m, with which the page begins (default: 0.02)")
    density.add_argument("--visibility", metavar="METRES", help="the same by visibility: 150 is --beta 0.01997")
    frame.add_argument(
        "--airlight", metavar="R,G,B", help="levels from 0 to 255 with which it begins (default: estimated)"
    )
    frame.add_argument(
        "--geometry",
        choices=GEOMETRIES,
        default="paper",
        help="distance along the ray as the published code has it, or from fx, fy and pixel centres (default: paper)",
    )
    own_frames.arguments(parser, images=False)
    run = parser.add_argument_group("a finished run", "predictions of its rows on its test sets, to results/view")
    run.add_argument("--results", action="store_true", help="make the pages of predictions")
    run.add_argument("--test-set", metavar="NAME", help="of this test set alone (default: of all in the params)")


def run(args: argparse.Namespace) -> None:
    """Run the step from the command line."""
    given = [name for name in (*FRAME, "camera", "fov", "intrinsics") if getattr(args, name) is not None]
    if args.results == bool(given):
        raise UsageError("give --rgb, --depth, --camera and --out for a frame, or --results for a finished run")
    if args.results:
        from foggy_synscapes.params import load

        params = load(args.params)
        for test_set in [args.test_set] if args.test_set else params.evaluate.test_sets:
            view(params, test_set)
        return
    needs_camera = args.depth_is != RAY
    if any(getattr(args, name) is None for name in FRAME) or (needs_camera and len(given) == len(FRAME)):
        raise UsageError("a frame is --rgb, --depth, --out and --camera, or --fov or --intrinsics in its place")
    if args.test_set:
        raise UsageError("--test-set belongs to --results")
    beta = 0.02 if args.beta is None else args.beta
    if args.visibility is not None:
        beta = float(of_visibility([args.visibility])[0])
    if not 0 <= beta < float("inf"):
        raise UsageError(f"--beta {beta}: expected a number of 1/m from 0 on, e.g. 0.02")
    light = None if args.airlight is None else _levels(args.airlight)
    job = GivenJob(args.out.parent, [], args.geometry, False, 0, KEEP, **own_frames.settings(args))
    camera = args.camera or args.depth  # a file that says nothing of a camera is not asked for one
    frame = GivenFrame(args.rgb.stem, args.rgb, args.depth, camera, in_depth=args.camera == args.depth)
    frame_view(job, frame, args.out, beta, light)


def frame_view(
    job: GivenJob, frame: GivenFrame, out: Path, beta: float = 0.02, light: tuple[int, int, int] | None = None
) -> None:
    """Write the page of one frame to `out`.

    job : how its depth is read; beta : 1/m, at least 0; light : levels, or None for the airlight of the image

    Raises FoggyError if a file is missing, damaged or of another size than the others.
    """
    clear, rays, warnings = job.clear(frame)
    found, _ = airlight_of(clear.image, KEEP)
    for warning in (*warnings, *clear.warnings(found)):
        print(f"warning: {warning}", file=sys.stderr)
    used = found if light is None else Airlight(*light, found.row, found.column)
    text = frame_page(frame.rgb.name, clear.image, clear.depth, rays, used, found, beta)
    write_text(out, text)
    print(f"view: {out}, {len(text) / 1e6:.1f} MB; airlight {', '.join(map(str, used.levels))}. Open it in a browser.")


def view(params: "Params", test_set: str) -> None:
    """Write the page of predictions on one test set to results/view.

    Raises
    ------
    UsageError
        If the params have no such test set.
    FoggyError
        If no row was scored on it, or an image or a prediction is missing, damaged or not as listed.
    """
    # What the experiment alone needs is imported here: a frame is looked at without it.
    from foggy_synscapes.figures.sources import Sources
    from foggy_synscapes.provenance.runs import Run
    from foggy_synscapes.results import roots
    from foggy_synscapes.steps import job
    from foggy_synscapes.view.predictions import predictions_page

    this = job(params, "view", test_set=test_set)
    if test_set not in params.evaluate.test_sets:
        raise UsageError(f"--test-set {test_set}: evaluate.test_sets has {', '.join(params.evaluate.test_sets)}")
    # Rows that were not made are left out of a page.
    made = Run(this, [path for path in this.read() if path.is_file()])
    sources = Sources(this, roots(params))
    rows = _rows(sources)
    if not rows:
        raise FoggyError(f"view: no predictions on {test_set}; run `foggy evaluate` first")
    title = f"Predictions on {sources.title()}"
    try:
        page = predictions_page(title, [row for _, row in rows], _images(sources, rows), params.stand_in)
    except ValueError as error:
        raise FoggyError(f"view: {test_set}: {error}") from error
    made.write(page=page)
    made.finish()
    print(f"view: {this.output('page')}, {len(page) / 1e6:.1f} MB, {len(rows)} rows. Open it in a browser.")


Key = tuple[str, str]  # network and row


def _rows(sources: "Sources") -> list[tuple[Key, "Row"]]:
    """Rows of which there are predictions, as the page calls them, with their scores on the whole test set."""
    from foggy_synscapes.view.predictions import Row

    return [
        ((network, row), Row(title, row, scores["mean_iou"]["annotated"]))
        for network, title in sources.networks.items()
        for row, scores in sources.scores(network).items()
    ]


def _images(sources: "Sources", rows: list[tuple[Key, "Row"]]) -> Iterator["Shown"]:
    from foggy_synscapes.io.pictures import encode_jpeg
    from foggy_synscapes.view.predictions import Shown

    for sample in sources.images(sources.params.view.images):
        predicted = [sources.predictions(*key, [sample.name])[0] for key, _ in rows]
        yield Shown(sample.name, encode_jpeg(sample.rgb, QUALITY), sample.truth, predicted)


def _levels(text: str) -> tuple[int, int, int]:
    parts = text.split(",")
    if len(parts) != 3 or not all(part.strip().isdecimal() and int(part) <= 255 for part in parts):
        raise UsageError(f"--airlight {text}: expected three levels from 0 to 255, e.g. 251,255,249")
    red, green, blue = map(int, parts)
    return red, green, blue
