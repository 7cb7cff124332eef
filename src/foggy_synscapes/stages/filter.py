"""filter: one table of all frames with their metadata, and which of them are kept. Reads no pixel."""

import argparse
from functools import partial
from pathlib import Path

import pandas as pd

from foggy_synscapes.datasets import synscapes
from foggy_synscapes.datasets.index import read_index
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.hashing import checked
from foggy_synscapes.io.progress import progress
from foggy_synscapes.params import FilterRule, Params, load
from foggy_synscapes.provenance.runs import Run
from foggy_synscapes.results import root
from foggy_synscapes.steps import job

HELP = "Keep frames by their metadata: one table of all frames, and the list of those kept."
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
        If a meta file is missing or damaged, or no frame is left.
    """
    run = Run(job(params, "filter"))
    index, folder = read_index(*run.job.inputs("synscapes")), root(params, "synscapes")
    ids = sorted(int(Path(path).stem) for path in index if path.startswith("meta/"))
    records = []
    for frame in progress(ids, "filter", unit="frame"):
        path = folder / synscapes.meta(frame)
        meta = synscapes.read_meta(path, partial(checked, expected=index[synscapes.meta(frame)], name=str(path)))
        camera = {name: getattr(meta.camera, name) for name in CAMERA}
        records.append({"id": frame, **{key: meta.scene[key] for key in synscapes.SCENE_KEYS}, **camera})
    # Numbers stay as the metadata has them: 0 and 0.5 in one column are not 0.0 and 0.5.
    frames = pd.DataFrame(records, columns=["id", *synscapes.SCENE_KEYS, *CAMERA], dtype=object)
    found = reasons(frames, params.filter.rules)
    frames = frames.assign(kept=found.eq("").astype(int), reason=found)
    kept = frames.loc[frames["kept"].eq(1), ["id", *CAMERA]]
    if kept.empty:
        raise FoggyError(f"filter.rules: none of {len(ids)} frames is left; loosen the rules")
    tables = {"frames": frames, "kept": kept}
    run.write(**{name: tables[name].to_csv(index=False, na_rep="nan", lineterminator="\n") for name in tables})
    run.finish()
    missing = frames[[*synscapes.SCENE_KEYS]].isna().sum()
    for key, count in missing[missing > 0].items():
        print(f"filter: {key} is missing, or no number, in the meta files of {count} frames; no rule on it keeps them")
    print(f"filter: kept {len(kept)} of {len(ids)} frames")


def reasons(frames: pd.DataFrame, rules: list[FilterRule]) -> pd.Series:
    """Why each frame is dropped: the rules that it breaks; empty for those that are kept.

    >>> frames = pd.DataFrame({"sky_contrast": [5.5, 2.0]})
    >>> list(reasons(frames, [FilterRule(key="sky_contrast", maximum=5.0)]))
    ['sky_contrast 5.5 above 5', '']
    """
    found = pd.Series("", index=frames.index, dtype=object)
    for rule in rules:
        values = frames[rule.key]
        for bound, holds, word in ((rule.minimum, values.ge, "below"), (rule.maximum, values.le, "above")):
            if bound is not None:
                said = [f"; {rule.key} {value:g} {word} {bound:g}" for value in values]
                # What is no number breaks every rule.
                found = found.where(holds(bound), found + said)
    return found.str.removeprefix("; ")
