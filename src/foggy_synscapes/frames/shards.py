"""Fog as jobs of the pipeline: the airlight table of a shard, and the shard of foggy images at one beta."""

import json
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

from foggy_synscapes.camera import Camera
from foggy_synscapes.datasets import synscapes, uris
from foggy_synscapes.datasets.index import expect, index_path, read_index
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.fog.airlight import Airlight
from foggy_synscapes.frames import recipes, rendering
from foggy_synscapes.io.atomic import write_bytes, write_text
from foggy_synscapes.io.hashing import read_checked, sha256
from foggy_synscapes.io.images import is_whole_png, read_rgb
from foggy_synscapes.io.progress import progress
from foggy_synscapes.io.shards import write_manifest, write_shard
from foggy_synscapes.io.tables import read_csv, write_csv
from foggy_synscapes.params import Params, root
from foggy_synscapes.provenance import source_digest
from foggy_synscapes.provenance.recorded import recorded
from foggy_synscapes.provenance.runs import checked_inputs, write_run

FOLDER = Path("results/fog")
KEPT = Path("results/filter/kept.csv")
COLUMNS = ("id", "red", "green", "blue", "row", "column", "blue_sky", "treatment")
AIRLIGHT_PARAMS = ("fog.frames", "fog.blue_airlight", "scenes.shard_frames")
FOG_PARAMS = (*AIRLIGHT_PARAMS, "fog.geometry", "fog.png_level", "fog.render")
ON_THE_FLY = "on_the_fly"


def airlight(params: Params, shard: str) -> None:
    """Write the table of the atmospheric light of a shard's frames, as it is to be used.

    `blue_sky` is 1 where the image's own light is blue, and `treatment` then says what is done about it.

    Raises FoggyError if an image is missing, damaged or not as indexed.
    """
    treatment, rows = params.fog.blue_airlight, []
    inputs = checked_inputs([index_path(f"synscapes/{shard}"), KEPT])
    rendering.keep_memory()
    index, folder = read_index(f"synscapes/{shard}"), root(params, "synscapes")
    for frame in progress(_frames(params, shard), f"fog airlight {shard}", unit="frame"):
        path = synscapes.rgb(frame)
        image = read_rgb(_read(folder, path, index), str(folder / path))
        light, blue = rendering.airlight_of(image, treatment)
        rows.append((frame, *light.levels, light.row, light.column, int(blue), treatment if blue else ""))
    table = FOLDER / "airlight" / f"{shard}.csv"
    write_csv(table, COLUMNS, rows)
    write_run(
        table.with_suffix(".run.json"),
        command=["foggy", "fog", "--airlight", "--shard", shard],
        params=recorded(params, *AIRLIGHT_PARAMS),
        inputs=inputs,
        outputs=[table],
    )
    blue = sum(row[6] for row in rows)
    print(f"fog: atmospheric light of {len(rows)} frames of shard {shard}; {blue} blue, fog.blue_airlight {treatment}")


def fog(params: Params, beta: str, shard: str) -> None:
    """Write the shard of foggy images at one beta, or of their recipes where `fog.render` says so, and its manifest.

    Frames that an interrupted run of the same job finished are kept.

    Raises FoggyError if a frame is missing, damaged, not as indexed, or cannot be fogged.
    """
    tar = FOLDER / f"beta_{beta}" / f"{shard}.tar"
    table, manifest = FOLDER / "airlight" / f"{shard}.csv", tar.with_suffix(".csv")
    inputs = checked_inputs([index_path(f"synscapes/{shard}"), KEPT, table])
    rendering.keep_memory()
    lights = {int(row["id"]): row for row in read_csv(table, COLUMNS)}
    finished = _finished(tar, {"inputs": inputs, "params": recorded(params, *FOG_PARAMS)})
    dropped: list[int] = []
    members = _members(params, beta, shard, lights, finished, dropped)
    write_manifest(manifest, write_shard(tar, members))
    write_run(
        tar.with_suffix(".run.json"),
        command=["foggy", "fog", "--beta", beta, "--shard", shard],
        params=recorded(params, *FOG_PARAMS),
        inputs=inputs,
        outputs=[tar, manifest],
    )
    shutil.rmtree(finished)
    left_out = f"; {len(dropped)} left out for their blue atmospheric light" if dropped else ""
    print(f"fog: shard {shard} at beta {beta} / m{left_out}")


def _members(
    params: Params, beta: str, shard: str, lights: dict[int, dict[str, str]], finished: Path, dropped: list[int]
) -> Iterator[tuple[str, bytes]]:
    """File names and contents of a shard's foggy images, sorted by name; ids of frames left out go to `dropped`."""
    index, folder = read_index(f"synscapes/{shard}"), root(params, "synscapes")
    for frame, camera in progress(_frames(params, shard).items(), f"fog {beta} {shard}", unit="frame"):
        if frame not in lights:
            raise FoggyError(
                f"{FOLDER}/airlight/{shard}.csv: no frame {frame}. Run foggy fog --airlight --shard {shard}"
            )
        if lights[frame]["treatment"] == rendering.DROP:
            dropped.append(frame)
            continue
        as_recipe, image = params.fog.render == ON_THE_FLY, synscapes.foggy_name(frame, beta)
        name = uris.recipe(image) if as_recipe else image
        if not ((finished / name).is_file() if as_recipe else is_whole_png(finished / name)):
            light = Airlight(*(int(lights[frame][column]) for column in ("red", "green", "blue", "row", "column")))
            clear = read_frame(folder, frame, index)
            rays = rendering.rays_of(clear, camera, f"{KEPT}, frame {frame}", params.fog.geometry)
            if as_recipe:
                data = recipes.write(clear, camera, params.fog.geometry, light, beta, frame, index)
            else:
                (data,) = rendering.foggy_pngs(clear, rays, light, [beta], params.fog.png_level)
            write_bytes(finished / name, data)
            for warning in clear.warnings(light):
                print(f"warning: {warning}", file=sys.stderr)
        yield name, (finished / name).read_bytes()


def _frames(params: Params, shard: str) -> dict[int, Camera]:
    """Cameras of the frames of a shard that fog.frames asks for: the first and the last kept ones."""
    rows, ends = read_csv(KEPT, ("id", "fx", "fy", "u0", "v0", "resx", "resy")), params.fog.frames
    if ends.first + ends.last > len(rows):
        raise FoggyError(
            f"fog.frames: asks for the first {ends.first} and the last {ends.last} kept frames, "
            f"but the filter kept {len(rows)}. Ask for fewer, loosen filter.rules, or add frames."
        )
    asked = {int(row["id"]): row for row in (*rows[: ends.first], *rows[len(rows) - ends.last :])}
    here = synscapes.shard_frames(shard, params.scenes.shard_frames)
    return {frame: synscapes.camera_of(row) for frame, row in sorted(asked.items()) if frame in here}


def read_frame(folder: Path, frame: int, index: dict[str, str]) -> rendering.Clear:
    """Read a frame of Synscapes whose files have to be as they were indexed."""
    paths = synscapes.rgb(frame), synscapes.depth(frame)
    return rendering.read_clear(
        *(_read(folder, path, index) for path in paths), *(str(folder / path) for path in paths)
    )


def _read(folder: Path, path: str, index: dict[str, str]) -> bytes:
    expect(index, [path], "synscapes")
    return read_checked(folder / path, index[path])


def _finished(tar: Path, job: dict) -> Path:
    """Folder of the images that an interrupted run of this very job finished; emptied where any input has changed."""
    folder = tar.parent / f".{tar.stem}"
    note = folder / "job.json"
    text = json.dumps(
        {**job, "code": [sha256(source_digest.FOLDER / name) for name in source_digest.sources("fog")]}, indent=1
    )
    if not note.is_file() or note.read_text(encoding="utf-8") != text:
        if folder.is_dir():
            shutil.rmtree(folder)
        write_text(note, text)
    return folder
