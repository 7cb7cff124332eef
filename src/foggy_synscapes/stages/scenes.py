"""scenes: render the stand-in where a dataset's root says so, and list what each dataset holds."""

import argparse
import hashlib
import json
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from foggy_synscapes.datasets import cityscapes, foggy_cityscapes, foggy_driving, foggy_zurich, synscapes
from foggy_synscapes.datasets.index import CACHE, FOLDER, index_path, write_index
from foggy_synscapes.errors import FoggyError, UsageError
from foggy_synscapes.io.atomic import write_bytes, write_text
from foggy_synscapes.io.hashing import sha256
from foggy_synscapes.io.progress import progress
from foggy_synscapes.params import STAND_IN, Params, load, root
from foggy_synscapes.provenance import source_digest
from foggy_synscapes.provenance.recorded import recorded
from foggy_synscapes.provenance.runs import versions, write_run
from foggy_synscapes.standin import layouts as stand_in

HELP = "Render the stand-in of a dataset where its root says so, and list what the dataset holds."
DATASETS = ("synscapes", "cityscapes", "foggy_cityscapes", "foggy_driving", "foggy_zurich")
CHECKPOINT = 100  # frames after which the record of what is made is saved

_REAL = """Frames of {name} are read from the folder that scenes.roots.{name} names; nothing is rendered here.
Their index is in results/scenes/index/{name}.
"""
_RENDERED = """Stand-in for {name}: drawn by a program, in the layout of the real dataset; no photograph is among them.
Their index is in results/scenes/index/{name}. Set scenes.roots.{name} to use the real dataset instead.
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this step."""
    parser.add_argument("--dataset", required=True, choices=DATASETS, help="which dataset")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="processes that render (default: 1)")


def run(args: argparse.Namespace) -> None:
    """Run the step from the command line."""
    scenes(load(args.params), args.dataset, args.jobs)


def scenes(params: Params, dataset: str, jobs: int = 1) -> None:
    """Render one dataset's stand-in to results/scenes, or read the real one, and write its index.

    Raises
    ------
    FoggyError
        If a file of the real dataset is missing, or the counts of the stand-in contradict each other.
    """
    if jobs < 1:
        raise UsageError(f"--jobs {jobs}: at least 1 process is needed")
    folder, rendered = root(params, dataset), getattr(params.scenes.roots, dataset) == STAND_IN
    readme = FOLDER.parent / dataset / "README.txt"
    if rendered:
        _render(params, dataset, folder, readme, jobs)
    elif not folder.is_dir():
        raise FoggyError(f"scenes.roots.{dataset}: {folder} is no folder. Give the dataset's folder, or {STAND_IN!r}.")
    indexes = _parts(params, dataset, folder, rendered)
    for name, paths in indexes.items():
        write_index(name, folder, paths)
    write_text(readme, (_RENDERED if rendered else _REAL).format(name=dataset))
    outputs = [index_path(name) for name in indexes]
    write_run(
        FOLDER / dataset / "run.json",
        command=["foggy", "scenes", "--dataset", dataset],
        params=recorded(params, *params.scenes.deciding(dataset)),
        inputs={},
        outputs=[*outputs, readme],
    )
    files = sum(len(paths) for paths in indexes.values())
    print(f"scenes {dataset}: {files} files of the {'stand-in' if rendered else 'real dataset'} listed")


def _frames(params: Params, dataset: str) -> list[stand_in.Frame]:
    plan = params.scenes.stand_in
    seed, size = plan.seed, (plan.size[0], plan.size[1])
    if dataset == "synscapes":
        return stand_in.synscapes_frames(seed, size, plan.synscapes)
    if dataset == "foggy_driving":
        return stand_in.driving_frames(seed, size, plan.foggy_driving.fine, plan.foggy_driving.coarse)
    if dataset == "foggy_zurich":
        return stand_in.zurich_frames(seed, size, plan.foggy_zurich)
    counts = plan.cityscapes.model_dump()
    if dataset == "cityscapes":
        return stand_in.cityscapes_frames(seed, size, counts)
    try:
        return stand_in.foggy_cityscapes_frames(seed, size, counts, plan.foggy_cityscapes.model_dump())
    except ValueError as error:
        raise FoggyError(f"scenes.stand_in.foggy_cityscapes: {error}; ask for fewer") from error


def _lists(params: Params, dataset: str, frames: list) -> stand_in.Files:
    if dataset == "foggy_cityscapes":
        return stand_in.refined_list(frames, params.scenes.refined_list)
    if dataset == "foggy_driving":
        return stand_in.driving_lists(frames)
    return stand_in.zurich_lists(frames) if dataset == "foggy_zurich" else []


def _render(params: Params, dataset: str, folder: Path, readme: Path, jobs: int) -> None:
    """Write every file of the stand-in that is not there already, and remove what is not part of it.

    Raises FoggyError if the folder is a link: what it leads to is not ours to write to or to clear.
    """
    if folder.resolve() != Path("results").resolve() / folder.relative_to("results"):
        raise FoggyError(
            f"{folder}: leads to {folder.resolve()}. The stand-in is not written through a link. Remove the link; "
            f"to read a dataset from there, name its folder in scenes.roots.{dataset}."
        )
    frames = _frames(params, dataset)
    made = _Made(CACHE / dataset / "frames.json", _fingerprint(params, dataset), folder)
    waiting = [frame for frame in frames if not made.has(frame.paths())]
    for number, files in enumerate(
        progress(_rendered(waiting, jobs), f"scenes {dataset}", total=len(waiting)), start=1
    ):
        for path, data in files:
            write_bytes(folder / path, data)
        made.add([path for path, _ in files])
        if number % CHECKPOINT == 0:
            made.save()
    made.save()
    lists = _lists(params, dataset, frames)
    for path, data in lists:
        write_bytes(folder / path, data)
    wanted = (
        {folder / path for frame in frames for path in frame.paths()} | {folder / path for path, _ in lists} | {readme}
    )
    for path in sorted(folder.rglob("*")):
        if path.is_file() and path not in wanted:
            path.unlink()


def _rendered(frames: list[stand_in.Frame], jobs: int) -> Iterator[stand_in.Files]:
    if jobs == 1 or len(frames) < 2:
        yield from map(_files, frames)
        return
    with ProcessPoolExecutor(min(jobs, len(frames))) as pool:
        yield from pool.map(_files, frames, chunksize=4)


def _files(frame: stand_in.Frame) -> stand_in.Files:
    return frame.files()


def _fingerprint(params: Params, dataset: str) -> str:
    """Changes with anything that can change a pixel: params, sources, library versions."""
    sources = {name: sha256(source_digest.FOLDER / name) for name in source_digest.sources("scenes")}
    drawn = recorded(params, *(key for key in params.scenes.deciding(dataset) if key.startswith("scenes.stand_in.")))
    document = [drawn, sources, versions("scenes")]
    return hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()


class _Made:
    """Which files an earlier, perhaps interrupted, run has made and nobody has touched since."""

    def __init__(self, path: Path, fingerprint: str, folder: Path) -> None:
        self.path, self.fingerprint, self.folder = path, fingerprint, folder
        self.files: dict[str, list[int]] = {}
        # The record only saves time: one that cannot be read, or of other params, is as good as none.
        try:
            document = json.loads(path.read_text(encoding="utf-8"))
            if document["fingerprint"] == fingerprint:
                self.files = document["files"]
        except (OSError, ValueError, KeyError, TypeError):
            pass

    def has(self, paths: Iterable[str]) -> bool:
        return all(path in self.files and self.files[path] == self._stamp(path) for path in paths)

    def add(self, paths: Iterable[str]) -> None:
        self.files.update((path, self._stamp(path)) for path in paths)

    def save(self) -> None:
        write_text(self.path, json.dumps({"fingerprint": self.fingerprint, "files": self.files}))

    def _stamp(self, path: str) -> list[int]:
        try:
            status = (self.folder / path).stat()
        except OSError:
            return []
        return [status.st_size, status.st_mtime_ns, status.st_ino]


def _parts(params: Params, dataset: str, folder: Path, rendered: bool) -> dict[str, list[str]]:
    """Files to list below the root, by name of the index."""
    if dataset == "synscapes":
        last = params.scenes.stand_in.synscapes if rendered else None
        return {
            f"synscapes/{shard}": _synscapes_files(
                folder, synscapes.shard_frames(shard, params.scenes.shard_frames, last)
            )
            for shard in params.scenes.shards
        }
    return {f"{dataset}/all": sorted(set(_files_of(params, dataset, folder)))}


def _synscapes_files(folder: Path, ids: range) -> list[str]:
    paths = []
    for frame in ids:
        own = [name(frame) for name in (synscapes.rgb, synscapes.depth, synscapes.class_, synscapes.meta)]
        missing = [path for path in own if not (folder / path).is_file()]
        if missing:
            raise FoggyError(
                f"{folder}: frame {frame} lacks {', '.join(missing)}. Frames {ids[0]} to {ids[-1]} need image, depth, "
                "class and meta; see scenes.shards and scenes.shard_frames."
            )
        paths += own
    return paths


def _files_of(params: Params, dataset: str, folder: Path) -> list[str]:
    if dataset == "cityscapes":
        images = [
            path.relative_to(folder).as_posix() for path in (folder / "leftImg8bit").glob("*/*/*_leftImg8bit.png")
        ]
        pairs = [pair for split in ("train", "val") for pair in cityscapes.pairs(images, split)]
        if not pairs:
            raise FoggyError(
                f"{folder}: no leftImg8bit/train or leftImg8bit/val images. Is this the Cityscapes folder?"
            )
        return [path for pair in pairs for path in pair]
    if dataset == "foggy_cityscapes":
        refined = foggy_cityscapes.read_refined(folder, params.scenes.refined_list)
        names = [frame for frames in refined.values() for frame in frames]
        betas = [
            beta
            for beta in foggy_cityscapes.BETAS
            if any((folder / foggy_cityscapes.image(name, beta)).is_file() for name in names)
        ]
        if not betas:
            raise FoggyError(
                f"{folder}: no leftImg8bit_foggy image of the refined frames. Is this the Foggy Cityscapes folder?"
            )
        return [params.scenes.refined_list, *(foggy_cityscapes.image(name, beta) for name in names for beta in betas)]
    if dataset == "foggy_driving":
        pairs, lists = foggy_driving.pairs(folder), [foggy_driving.IMAGES, foggy_driving.LABELS]
    else:
        version = params.scenes.zurich_list
        pairs = foggy_zurich.pairs(folder, version)
        lists = [foggy_zurich.list_path(kind, version) for kind in ("RGB", "gt_labelIds")]
    return [*lists, *(path for pair in pairs for path in pair)]
