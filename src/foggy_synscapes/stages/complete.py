"""complete: depth at every pixel from stereo, and the airlight of its frames; alone: on any frames."""

import argparse
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from foggy_synscapes.datasets.index import read_index
from foggy_synscapes.errors import UsageError
from foggy_synscapes.fog.airlight import estimate
from foggy_synscapes.fog.geometry import GEOMETRIES
from foggy_synscapes.frames import by_layout, folders, standalone
from foggy_synscapes.frames.asked import asked_frames
from foggy_synscapes.frames.comparing import compare
from foggy_synscapes.frames.layouts import LAYOUTS
from foggy_synscapes.frames.stereo_shards import DATASET, Indexed, depth, depth_name
from foggy_synscapes.io.arrays import is_whole_npz
from foggy_synscapes.io.atomic import write_bytes
from foggy_synscapes.io.progress import progress
from foggy_synscapes.io.shards import write_manifest, write_shard
from foggy_synscapes.io.tables import write_csv
from foggy_synscapes.provenance import source_digest

if TYPE_CHECKING:  # only jobs of the pipeline know params, which are imported with their libraries where they are used
    from foggy_synscapes.params import Params

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
    made.add_argument(
        "--compare",
        type=Path,
        nargs=2,
        metavar="DIR",
        help="instead: how far two folders of Foggy Cityscapes are apart, e.g. made here and downloaded",
    )
    job = parser.add_argument_group("pipeline", "one job, as params.yaml describes it")
    job.add_argument("--shard", metavar="NAME", help="shard of Cityscapes' stereo frames, e.g. 0000")
    job.add_argument(
        "--synscapes-shard", metavar="NAME", help="shard of Synscapes, as a simulated stereo camera measures it"
    )


def run(args: argparse.Namespace) -> None:
    """Run the step from the command line."""
    if args.compare is not None:
        print(f"complete: {compare(*args.compare)}")
        return
    if args.shard is not None or args.synscapes_shard is not None:
        if args.layout is not None or args.out is not None:
            raise UsageError("--layout and --out are not for jobs of the pipeline (--shard)")
        from foggy_synscapes.params import load

        if args.synscapes_shard is not None:
            complete_synscapes(load(args.params), args.synscapes_shard)
        else:
            complete(load(args.params), args.shard)
        return
    if args.out is None or args.layout is None:
        raise UsageError("give --layout cityscapes, --root and --out (or --shard)")
    betas = standalone.betas_of(args.beta or [])
    frames, job = by_layout.frames(args, folders.Job(args.out, betas, args.geometry, False, 1, "keep"), depth=True)
    code = source_digest.identity(*source_digest.code(WORD, (f"layouts.{args.layout}",), {"layouts": LAYOUTS}))
    standalone.fog(frames, job, code, jobs=args.jobs, keep_going=args.keep_going, word=WORD)


def complete(params: "Params", shard: str) -> None:
    """Write the shard of completed depth of some stereo frames, its manifest, and the table of their airlight.

    Frames that an interrupted run of the same job finished are kept.

    Raises FoggyError if there is no such job, or a file is missing, damaged or not as indexed, or has no depth.
    """
    from foggy_synscapes.provenance import unfinished
    from foggy_synscapes.provenance.runs import Run
    from foggy_synscapes.results import root
    from foggy_synscapes.steps import job

    made = params.complete
    if made is None or shard not in made.shards:
        known = ", ".join(made.shards) if made else "none, as there is no section complete"
        raise UsageError(f"--shard {shard}: not in complete.shards, which has {known}")
    run = Run(job(params, WORD, shard=shard))
    finished, rows = unfinished.folder_of(run), []
    indexed = Indexed(root(params, DATASET), read_index(run.job.input("index")))
    frames = indexed.frames(shard, made.shards, made.shard_frames)

    def members() -> Iterator[tuple[str, bytes]]:
        for frame in progress(frames, f"complete {shard}", unit="frame"):
            name, views = depth_name(frame), indexed.views(frame)
            light = estimate(views.left)
            rows.append((frame, *light.levels, light.row, light.column))
            if not is_whole_npz(finished / name):
                data, warnings = depth(views, made.seed, made.superpixels)
                write_bytes(finished / name, data)
                for warning in warnings:
                    print(f"warning: {warning}", file=sys.stderr)
            yield name, (finished / name).read_bytes()

    write_manifest(run.job.output("manifest"), write_shard(run.job.output("shard"), members()))
    write_csv(run.job.output("airlight"), standalone.COLUMNS, rows)
    run.finish()
    shutil.rmtree(finished)
    print(f"complete: depth of {len(rows)} frames of shard {shard}")


def complete_synscapes(params: "Params", shard: str) -> None:
    """Write the shard of depth that a simulated stereo camera has of some frames of Synscapes, and its manifest.

    Frames that an interrupted run of the same job finished are kept.

    Raises FoggyError if there is no such job, or a file is missing, damaged or not as indexed, or has no depth.
    """
    from foggy_synscapes.frames import of_completed_depth
    from foggy_synscapes.provenance import unfinished
    from foggy_synscapes.provenance.runs import Run
    from foggy_synscapes.results import root
    from foggy_synscapes.steps import job

    stereo = params.stereo
    if stereo is None or shard not in params.scenes.shards:
        raise UsageError(f"--synscapes-shard {shard}: not in scenes.shards, or there is no section stereo")
    run = Run(job(params, "complete_synscapes", shard=shard))
    finished = unfinished.folder_of(run)
    cameras = asked_frames(params, shard, run.job.input("kept"))
    frames = of_completed_depth.Indexed(root(params, "synscapes"), read_index(run.job.input("index")), cameras)

    def members() -> Iterator[tuple[str, bytes]]:
        made = of_completed_depth.depths(frames, stereo.errors(), stereo.seed, stereo.superpixels)
        for name, make in progress(made, f"complete synscapes {shard}", total=len(cameras), unit="frame"):
            if not is_whole_npz(finished / name):
                write_bytes(finished / name, make())
            yield name, (finished / name).read_bytes()

    write_manifest(run.job.output("manifest"), write_shard(run.job.output("shard"), members()))
    run.finish()
    shutil.rmtree(finished)
    print(f"complete: depth of {len(cameras)} frames of Synscapes' shard {shard}, as from a stereo camera")
