"""Which frames of Synscapes an experiment fogs."""

from pathlib import Path
from typing import TYPE_CHECKING

from foggy_synscapes.camera import Camera
from foggy_synscapes.datasets import synscapes
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.files import named
from foggy_synscapes.io.tables import read_csv

if TYPE_CHECKING:
    from foggy_synscapes.params import Params


def asked_frames(params: "Params", shard: str, kept: Path) -> dict[int, Camera]:
    """Cameras of the frames of a shard that fog.frames asks for: the first and the last kept ones."""
    rows, ends = read_csv(kept, ("id", "fx", "fy", "u0", "v0", "resx", "resy")), params.fog.frames
    if ends.first + ends.last > len(rows):
        raise FoggyError(
            f"fog.frames: asks for the first {ends.first} and the last {ends.last} kept frames, "
            f"but the filter kept {len(rows)}. Ask for fewer, loosen filter.rules, or add frames."
        )
    here = synscapes.shard_frames(shard, params.scenes.shard_frames)
    with named(kept, "table of frames"):
        asked = {int(row["id"]): row for row in (*rows[: ends.first], *rows[len(rows) - ends.last :])}
        return {frame: synscapes.camera_of(row) for frame, row in sorted(asked.items()) if frame in here}
