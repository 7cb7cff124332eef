"""filter: one table of all frames with their metadata, and which of them are kept. Reads no pixel."""

import argparse
from pathlib import Path

from foggy_synscapes.datasets import synscapes
from foggy_synscapes.datasets.index import index_path, read_index
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.hashing import checked
from foggy_synscapes.io.progress import progress
from foggy_synscapes.io.tables import write_csv
from foggy_synscapes.params import FilterRule, Params, load, root
from foggy_synscapes.provenance.recorded import recorded
from foggy_synscapes.provenance.runs import checked_inputs, write_run

HELP = "Keep frames by their metadata: one table of all frames, and the list of those kept."
FOLDER = Path("results/filter")
CAMERA = ("fx", "fy", "u0", "v0", "resx", "resy")


def arguments(parser: argparse.ArgumentParser) -> None:
    """This step has no options of its own."""


def run(args: argparse.Namespace) -> None:
    """Run the step from the command line."""
    filter(load(args.params))


def filter(params: Params) -> None:
    """Write `frames.csv` (id, every scene key, camera, kept, reason) and `kept.csv` (id, camera) to results/filter.

    Raises
    ------
    FoggyError
        If a meta file is missing or lacks a key, or no frame is left.
    """
    names = [f"synscapes/{shard}" for shard in params.scenes.shards]
    inputs = checked_inputs(index_path(name) for name in names)
    index, folder = read_index(*names), root(params, "synscapes")
    ids = sorted(int(Path(path).stem) for path in index if path.startswith("meta/"))
    frames, kept = [], []
    for frame in progress(ids, "filter", unit="frame"):
        path = folder / synscapes.meta(frame)
        meta = synscapes.read_meta(
            path, check=lambda data, p=path, f=frame: checked(data, index[synscapes.meta(f)], str(p))
        )
        reason = "; ".join(filter_out(meta.scene, params.filter.rules))
        camera = [getattr(meta.camera, name) for name in CAMERA]
        frames.append([frame, *(meta.scene[key] for key in synscapes.SCENE_KEYS), *camera, int(not reason), reason])
        if not reason:
            kept.append([frame, *camera])
    if not kept:
        raise FoggyError(f"filter.rules: none of {len(ids)} frames is left; loosen the rules")
    outputs = [FOLDER / "frames.csv", FOLDER / "kept.csv"]
    write_csv(outputs[0], ("id", *synscapes.SCENE_KEYS, *CAMERA, "kept", "reason"), frames)
    write_csv(outputs[1], ("id", *CAMERA), kept)
    write_run(
        FOLDER / "run.json",
        command=["foggy", "filter"],
        params=recorded(params, "filter", "scenes.shards"),
        inputs=inputs,
        outputs=outputs,
    )
    print(f"filter: kept {len(kept)} of {len(ids)} frames")


def filter_out(scene: dict[str, float], rules: list[FilterRule]) -> list[str]:
    """Reasons against a frame, one for each rule that it breaks.

    >>> filter_out({"sky_contrast": 5.5}, [FilterRule(key="sky_contrast", maximum=5.0)])
    ['sky_contrast 5.5 above 5']
    """
    reasons = []
    for rule in rules:
        value = scene[rule.key]
        if rule.minimum is not None and not value >= rule.minimum:
            reasons.append(f"{rule.key} {value:g} below {rule.minimum:g}")
        if rule.maximum is not None and not value <= rule.maximum:
            reasons.append(f"{rule.key} {value:g} above {rule.maximum:g}")
    return reasons
