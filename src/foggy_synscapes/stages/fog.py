"""fog: the airlight of a shard's frames, and the shard of foggy images at one beta; alone: fog on any frames."""

import argparse
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from foggy_synscapes.datasets import synscapes, uris
from foggy_synscapes.datasets.index import read_index
from foggy_synscapes.depth import quality
from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.fog.airlight import Airlight
from foggy_synscapes.frames import rendering, standalone
from foggy_synscapes.frames.asked import asked_frames
from foggy_synscapes.frames.layouts import LAYOUTS, Wanted
from foggy_synscapes.io.atomic import write_bytes
from foggy_synscapes.io.files import named, read_bytes
from foggy_synscapes.io.images import is_whole_png, read_rgb
from foggy_synscapes.io.progress import progress
from foggy_synscapes.io.shards import Shard, write_manifest, write_shard
from foggy_synscapes.io.tables import read_csv, write_csv
from foggy_synscapes.provenance import source_digest

if TYPE_CHECKING:  # only jobs of the pipeline know params, which are imported with their libraries where they are used
    from foggy_synscapes.jobs import Job
    from foggy_synscapes.params import Params

HELP = "Render fog on frames: any folder of RGB and depth, or one job of the pipeline."
COLUMNS = ("id", "red", "green", "blue", "row", "column", "blue_sky", "treatment")
ON_THE_FLY = "on_the_fly"


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this step."""
    standalone.arguments(parser)
    job = parser.add_argument_group("pipeline", "one job, as params.yaml describes it; with one --beta or --airlight")
    job.add_argument("--shard", metavar="NAME", help="shard of Synscapes, e.g. 0000")
    job.add_argument("--stereo", metavar="NAME", help="shard of Cityscapes' stereo frames, e.g. 0000")
    job.add_argument("--completed", metavar="NAME", help="shard of Synscapes whose depth was completed, e.g. 0000")
    job.add_argument("--airlight", action="store_true", help="estimate the airlight only")


def run(args: argparse.Namespace) -> None:
    """Run the step from the command line."""
    if args.airlight or any(name is not None for name in (args.shard, args.stereo, args.completed)):
        _run_job(args)
    else:
        layout = (f"layouts.{args.layout}",) if args.layout else ()
        standalone.run(args, source_digest.identity(*source_digest.code("fog", layout, {"layouts": LAYOUTS})))


def _run_job(args: argparse.Namespace) -> None:
    alone_only = [
        name for name in ("synscapes", "rgb", "depth", "out", "ids", "camera", "layout") if getattr(args, name)
    ]
    if alone_only:
        raise UsageError(f"--{alone_only[0]} is not for jobs of the pipeline (--shard, --stereo, --airlight)")
    from foggy_synscapes.params import load

    betas = args.beta or []
    if args.stereo is not None:
        if args.shard is not None or args.airlight or len(betas) != 1:
            raise UsageError("--stereo goes with one --beta")
        fog_made(load(args.params), betas[0], args.stereo)
        return
    if args.completed is not None:
        if args.shard is not None or args.airlight or len(betas) != 1:
            raise UsageError("--completed goes with one --beta")
        fog_completed(load(args.params), betas[0], args.completed)
        return
    if args.shard is None or bool(betas) == args.airlight or len(betas) > 1:
        raise UsageError("a job of the pipeline has --shard and either --airlight or one --beta")
    if args.airlight:
        airlight(load(args.params), args.shard)
    else:
        fog(load(args.params), betas[0], args.shard, args.model)


def airlight(params: "Params", shard: str) -> None:
    """Write the table of the airlight of a shard's frames, as it is to be used.

    `blue_sky` is 1 where the image's own airlight is blue, and `treatment` then says what is done about it.

    Raises FoggyError if an image is missing, damaged or not as indexed.
    """
    from foggy_synscapes.provenance.runs import Run
    from foggy_synscapes.results import root
    from foggy_synscapes.steps import job

    run = Run(job(params, "fog_airlight", shard=shard))
    treatment, rows = params.fog.blue_airlight, []
    rendering.keep_memory()
    index, folder = read_index(run.job.input("index")), root(params, "synscapes")
    frames = asked_frames(params, shard, run.job.input("kept"))
    for frame in progress(frames, f"fog airlight {shard}", unit="frame"):
        path = synscapes.rgb(frame)
        image = read_rgb(rendering.read_indexed(folder, path, index), str(folder / path))
        light, blue = rendering.airlight_of(image, treatment)
        rows.append((frame, *light.levels, light.row, light.column, int(blue), treatment if blue else ""))
    write_csv(run.job.output("airlight"), COLUMNS, rows)
    run.finish()
    count = sum(row[6] for row in rows)
    print(f"fog: airlight of {len(rows)} frames of shard {shard}; {count} blue, fog.blue_airlight {treatment}")


def fog(params: "Params", beta: str, shard: str, model: str | None = None) -> None:
    """Write the shard of foggy images at one beta, or of their recipes where `fog.render` says so, and its manifest.

    model : one of fog.also; None: fog.model

    Frames that an interrupted run of the same job finished are kept.

    Raises FoggyError if a frame is missing, damaged, not as indexed, or cannot be fogged.
    """
    from foggy_synscapes.provenance import unfinished
    from foggy_synscapes.provenance.runs import Run
    from foggy_synscapes.steps import job

    named = {"model": model} if model is not None else {}
    run = Run(job(params, "fog", beta=beta, shard=shard, **named))
    rendering.keep_memory()
    finished = unfinished.folder_of(run)
    dropped: list[int] = []
    members = write_shard(run.job.output("shard"), _members(run.job, finished, dropped))
    write_manifest(run.job.output("manifest"), members)
    run.finish()
    shutil.rmtree(finished)
    left_out = f"; {len(dropped)} left out for their blue airlight" if dropped else ""
    print(f"fog: shard {shard} at beta {beta} / m{f' by {model}' if model else ''}{left_out}")


def fog_made(params: "Params", beta: str, shard: str) -> None:
    """Write a shard of Foggy Cityscapes at one beta, of depth completed from stereo, and its manifest.

    Frames that an interrupted run of the same job finished are kept.

    Raises FoggyError if there is no such job, or a file is missing, damaged or not as indexed.
    """
    from foggy_synscapes.provenance import unfinished
    from foggy_synscapes.provenance.runs import Run
    from foggy_synscapes.results import root
    from foggy_synscapes.steps import job

    made = params.complete
    if made is None or shard not in made.shards or beta not in made.betas:
        known = f"shards {', '.join(made.shards)}, betas {', '.join(made.betas)}" if made else "none"
        raise UsageError(f"--stereo {shard} --beta {beta}: not in the params section complete, which has {known}")
    run = Run(job(params, "fog_made", beta=beta, stereo=shard))
    finished = unfinished.folder_of(run)
    index, light = read_index(run.job.input("index")), run.job.input("airlight")
    with named(light, "table of airlight"):
        rows = read_csv(light, COLUMNS[:4])
        lights = {row["id"]: (int(row["red"]), int(row["green"]), int(row["blue"])) for row in rows}
    where = root(params, "cityscapes_stereo"), index, run.job.input("depth"), lights
    members = LAYOUTS["cityscapes"].members
    assert members is not None  # it completes depth
    wanted = members(Wanted(*where, beta, made.refine, params.fog.geometry, params.fog.png_level))

    def images() -> Iterator[tuple[str, bytes]]:
        for name, make in progress(wanted, f"fog made {beta} {shard}", total=len(lights), unit="frame"):
            if not is_whole_png(finished / name):
                write_bytes(finished / name, make())
            yield name, (finished / name).read_bytes()

    write_manifest(run.job.output("manifest"), write_shard(run.job.output("shard"), images()))
    run.finish()
    shutil.rmtree(finished)
    print(f"fog: {len(lights)} images of shard {shard} made at beta {beta} / m")


def fog_completed(params: "Params", beta: str, shard: str) -> None:
    """Write a shard of Foggy Synscapes of completed depth, its manifest, and its errors by class and distance.

    Raises FoggyError if there is no such job, or a file is missing, damaged or not as indexed.
    """
    from foggy_synscapes.frames import of_completed_depth
    from foggy_synscapes.labels import CLASSES
    from foggy_synscapes.provenance.runs import Run
    from foggy_synscapes.results import root
    from foggy_synscapes.steps import job

    run = Run(job(params, "fog_completed", beta=beta, completed=shard))
    lights = _lights(run.job.input("airlight"))
    cameras = asked_frames(params, shard, run.job.input("kept"))
    cameras = {frame: camera for frame, camera in cameras.items() if lights[frame][1] != rendering.DROP}
    frames = of_completed_depth.Indexed(root(params, "synscapes"), read_index(run.job.input("index")), cameras)
    sums = np.zeros((len(CLASSES) + 1, len(quality.GROUPS), len(quality.SUMS)))
    with Shard(run.job.input("depth")) as depth:
        levels = {frame: lights[frame][0].levels for frame in cameras}
        made = of_completed_depth.foggy(frames, depth, levels, beta, params.fog.geometry, params.fog.png_level)

        def images() -> Iterator[tuple[str, bytes]]:
            for name, data, errors in progress(made, f"fog completed {beta} {shard}", total=len(cameras), unit="frame"):
                sums[:] += errors
                yield name, data

        write_manifest(run.job.output("manifest"), write_shard(run.job.output("shard"), images()))
    write_csv(run.job.output("errors"), of_completed_depth.COLUMNS, of_completed_depth.rows(sums))
    run.finish()
    print(f"fog: {len(cameras)} images of shard {shard} of completed depth at beta {beta} / m")


def _members(job: "Job", finished: Path, dropped: list[int]) -> Iterator[tuple[str, bytes]]:
    """File names and contents of a shard's foggy images, sorted by name; ids of frames left out go to `dropped`."""
    from foggy_synscapes.frames import recipes
    from foggy_synscapes.results import root

    params, beta, shard, kept = job.params, job.values["beta"], job.values["shard"], job.input("kept")
    model = params.fog.spelt(job.values.get("model", ""))
    lights = _lights(job.input("airlight"))
    index, folder = read_index(job.input("index")), root(params, "synscapes")
    for frame, camera in progress(asked_frames(params, shard, kept).items(), f"fog {beta} {shard}", unit="frame"):
        if frame not in lights:
            raise FoggyError(f"{job.input('airlight')}: no frame {frame}. Run foggy fog --airlight --shard {shard}")
        light, treatment = lights[frame]
        if treatment == rendering.DROP:
            dropped.append(frame)
            continue
        as_recipe, image = params.fog.render == ON_THE_FLY, synscapes.foggy_name(frame, beta)
        name = uris.recipe(image) if as_recipe else image
        if not ((finished / name).is_file() if as_recipe else is_whole_png(finished / name)):
            clear = rendering.read_frame(folder, frame, index)
            rays = rendering.rays_of(clear, camera, f"{kept}, frame {frame}", params.fog.geometry)
            if as_recipe:
                data = recipes.write(clear, camera, params.fog, light, beta, frame, index, model)
            else:
                (data,) = rendering.foggy_pngs(model, clear, rays, light, [beta], params.fog.png_level)
            write_bytes(finished / name, data)
            for warning in clear.warnings(light):
                print(f"warning: {warning}", file=sys.stderr)
        yield name, read_bytes(finished / name)


def _lights(table: Path) -> dict[int, tuple[Airlight, str]]:
    """Airlight by frame, and what is done about it."""
    rows = read_csv(table, COLUMNS)
    with named(table, "table of airlight"):
        return {
            int(row["id"]): (Airlight(*(int(row[column]) for column in COLUMNS[1:6])), row["treatment"]) for row in rows
        }
