"""scenes: render the stand-in where a dataset's root says so, and list what each dataset holds."""

import argparse
import json
from pathlib import Path

from foggy_synscapes.datasets.index import write_index
from foggy_synscapes.datasets.roots import files_of
from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.io.atomic import write_text
from foggy_synscapes.io.checksums import Checksums
from foggy_synscapes.io.hashing import sha256_bytes
from foggy_synscapes.io.stamps import CACHE
from foggy_synscapes.params import STAND_IN, Params, load
from foggy_synscapes.provenance.runs import Run, recorded
from foggy_synscapes.results import RESULTS, root
from foggy_synscapes.standin.drawing import Made, draw
from foggy_synscapes.standin.layouts import STAND_INS
from foggy_synscapes.steps import drawn_by, job

HELP = "Render the stand-in of a dataset where its root says so, and list what the dataset holds."

_REAL = """Frames of {name} are read from the folder that scenes.roots.{name} names; nothing is rendered here.
Their index is in {indexes}.
"""
_RENDERED = """Stand-in for {name}: drawn by a program, in the layout of the real dataset; no photograph is among them.
Their index is in {indexes}. Set scenes.roots.{name} to use the real dataset instead.
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this step."""
    parser.add_argument("--dataset", required=True, help="which dataset: a key of scenes.roots")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="processes that render (default: 1)")
    parser.add_argument("--checksums", type=Path, metavar="FILE", help="SHA-256 of its files, as sha256sum writes them")


def run(args: argparse.Namespace) -> None:
    """Run the step from the command line."""
    params = load(args.params)
    if args.dataset not in params.scenes.roots:
        raise UsageError(f"--dataset {args.dataset}: scenes.roots has {', '.join(params.scenes.roots)}")
    scenes(params, args.dataset, args.jobs, Checksums(args.checksums) if args.checksums else None)


def scenes(params: Params, dataset: str, jobs: int = 1, checksums: Checksums | None = None) -> None:
    """Render one dataset's stand-in to results/scenes, or read the real one, and write its index.

    Raises
    ------
    FoggyError
        If the folder is not that dataset or lacks a file of it (`datasets.roots`), if a file is not as `checksums` say,
        or if the counts of the stand-in contradict each other.
    """
    if jobs < 1:
        raise UsageError(f"--jobs {jobs}: at least 1 process is needed")
    folder, rendered = root(params, dataset), params.scenes.roots[dataset] == STAND_IN
    run = Run(job(params, f"scenes_{dataset}"))
    if rendered:
        _render(run, dataset, folder, jobs)
    listed = 0
    for index in run.job.outputs("index"):
        paths = files_of(dataset, folder, params.scenes, index.stem)
        write_index(index, folder, paths, checksums)
        listed += len(paths)
    text = (_RENDERED if rendered else _REAL).format(name=dataset, indexes=run.job.output("record").parent)
    write_text(run.job.output("readme"), text)
    run.finish()
    print(f"scenes {dataset}: {listed} files of the {'stand-in' if rendered else 'real dataset'} listed")


def _render(run: Run, dataset: str, folder: Path, jobs: int) -> None:
    """Raises FoggyError if the folder is a link: what it leads to is not ours to write to or to clear."""
    if folder.resolve() != Path(RESULTS).resolve() / folder.relative_to(RESULTS):
        raise FoggyError(
            f"{folder}: leads to {folder.resolve()}. The stand-in is not written through a link. Remove the link; "
            f"to read a dataset from there, name its folder in scenes.roots.{dataset}."
        )
    entry, scenes = STAND_INS[dataset], run.job.params.scenes
    try:
        frames = entry.frames(scenes.stand_in)
    except ValueError as error:
        raise FoggyError(f"scenes.stand_in.{dataset}: {error}") from error
    # What is there was made by the same code, libraries and params, or is made again.
    drawn = recorded(run.job.params, *drawn_by(dataset))
    fingerprint = sha256_bytes(json.dumps([drawn, run.code, run.libraries], sort_keys=True).encode())
    made = Made(CACHE / dataset / "frames.json", fingerprint, folder)
    draw(frames, entry.lists(frames, scenes), made, run.job.output("readme"), jobs, f"scenes {dataset}")
