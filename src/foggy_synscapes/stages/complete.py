"""complete: depth at every pixel from stereo, and its transmittance, refined."""

import argparse
from pathlib import Path

from foggy_synscapes.errors import UsageError
from foggy_synscapes.fog.geometry import GEOMETRIES
from foggy_synscapes.frames import by_layout, folders, standalone
from foggy_synscapes.provenance import source_digest
from foggy_synscapes.steps import REGISTRIES

HELP = "Complete depth from stereo: DIR/depth/SPLIT/CITY/NAME_depth.npz (planar metres), transmittance, airlight."
WORD = "complete"


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this step."""
    by_layout.arguments(parser)
    made = parser.add_argument_group("result")
    made.add_argument("--out", type=Path, metavar="DIR", help="where to write depth and airlight.csv")
    made.add_argument(
        "--beta", action="append", metavar="B", help="also write 8-bit transmittance at B / m; several: --beta again"
    )
    made.add_argument(
        "--geometry", choices=GEOMETRIES, default="paper", help="of the distance along the ray (default: paper)"
    )
    made.add_argument("--jobs", type=int, default=1, metavar="N", help="processes (default: 1)")
    made.add_argument("--keep-going", action="store_true", help="finish the other frames where one is broken")


def run(args: argparse.Namespace) -> None:
    """Run the step from the command line."""
    if args.out is None or args.layout is None:
        raise UsageError("give --layout cityscapes, --root and --out")
    betas = standalone.betas_of(args.beta or [])
    frames, job = by_layout.frames(args, folders.Job(args.out, betas, args.geometry, False, 1, "keep"), depth=True)
    code = source_digest.identity(*source_digest.code(WORD, (f"layouts.{args.layout}",), REGISTRIES))
    standalone.fog(frames, job, code, jobs=args.jobs, keep_going=args.keep_going, word=WORD)
