"""What planning costs as the data grows: python benchmarks/scale.py [--frames 200 1000 5000 25000]

A copy of params/paper.yaml with the paper's five betas is planned on a fake Synscapes of so many frames: 25,000 frames
are 125,000 foggy images. Pixels are sparse files of the size of real ones, never read; metadata is small and whole.
Per size, in a clone in a temporary folder:
  planned     `snakemake --dry-run` where only the indexes are made: every job is to run
  made        `snakemake --dry-run` where every result is there (sparse): nothing is to run
  filter, subset, refresh
              `foggy filter` over all metadata, `foggy subset` of the longest list, and `foggy scenes` a second time
  dvc status, dvc repro
              the same by DVC where nothing is made: `dvc status`, and `dvc repro --dry --force`
Exit status 1 where the largest size is over the targets, or time grows faster than the images.
"""

import argparse
import json
import random
import re
import sys
import tempfile
from pathlib import Path

import yaml

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests/helpers"))

from clones import ROOT, Call, call, clone, table

from foggy_synscapes.datasets import synscapes
from foggy_synscapes.datasets.index import CACHE
from foggy_synscapes.io.hashing import sha256
from foggy_synscapes.io.tables import write_csv
from foggy_synscapes.params import Params, check, load, resolved

BETAS = ("0.005", "0.01", "0.02", "0.03", "0.06")
SECONDS, MEGABYTES = 15.0, 1000.0  # targets of a dry run at full size
SIZES = {"rgb": 1_600_000, "depth": 4_100_000, "class": 60_000}  # bytes of the real samples' files, about


def document(frames: int) -> dict:
    """The paper's params with five betas over so many frames, a row per beta; small datasets are left as stand-ins."""
    params = resolved.document(load(ROOT / "params/paper.yaml"))
    held_out = min(500, frames // 10)
    train = frames - held_out
    params["scenes"]["roots"] = dict.fromkeys(params["scenes"]["roots"], "stand-in") | {"synscapes": "data/Synscapes"}
    # Shards of real data are whole; below 500 frames there is one.
    params["scenes"]["shard_frames"] = size = min(500, frames)
    params["scenes"]["shards"] = [f"{number:04d}" for number in range(frames // size)]
    params["fog"] |= {"betas": list(BETAS), "frames": {"first": train, "last": held_out}}
    pure, mixed = params["subset"]["pure"], params["subset"]["mixed"]
    for entry in (*pure.values(), *mixed.values()):
        entry |= {"train": min(entry["train"], train), "validation": held_out}
    pure["FS-24500"]["train"] = train
    for beta in BETAS[1:]:
        row = f"FS-beta-{beta.replace('.', '-')}"
        pure[row] = pure["FS-24500"] | {"beta": beta}
        params["train"]["from_baseline"].append(row)
        params["train"]["rows"][row] = params["train"]["rows"]["FS-24500"]
    return json.loads(json.dumps(params))  # without shared parts, which YAML would write as aliases


def fake(folder: Path, params: Params) -> None:
    """A Synscapes of sparse images and small metadata, and the note of its hashes that `foggy scenes` goes by."""
    root, random_ = folder / "data/Synscapes", random.Random(2019)
    for kind in ("img/rgb", "img/depth", "img/class", "meta"):
        (root / kind).mkdir(parents=True)
    camera = {"fx": 1590.8, "fy": 1592.8, "u0": 771.3, "v0": 360.8, "resx": 1440, "resy": 720}
    for shard in params.scenes.shards:
        known = {}
        for frame in synscapes.shard_frames(shard, params.scenes.shard_frames):
            for path in (synscapes.rgb(frame), synscapes.depth(frame), synscapes.class_(frame)):
                with open(root / path, "wb") as file:
                    file.truncate(SIZES[path.split("/")[1]])
                known[path] = [_stamp(root / path), f"{random_.getrandbits(256):064x}"]
            scene = {key: round(random_.random(), 3) for key in synscapes.SCENE_KEYS}
            text = json.dumps({"camera": {"intrinsic": camera}, "scene": scene, "instance": {}})
            (root / synscapes.meta(frame)).write_text(text)
        note = folder / CACHE / f"synscapes/{shard}.json"
        note.parent.mkdir(parents=True, exist_ok=True)
        note.write_text(json.dumps(known))


def _stamp(path: Path) -> list[int]:
    status = path.stat()
    return [status.st_size, status.st_mtime_ns, status.st_ino]


def plan(folder: Path, frames: int) -> Params:
    """Put the fake data and its params file into a clone."""
    values = document(frames)
    (folder / "params/scale.yaml").write_text(yaml.safe_dump(values, sort_keys=False))
    params = check(values, "params/scale.yaml")
    fake(folder, params)
    return params


def planned(folder: Path, *options: str) -> Call:
    """A dry run, as a person would ask for it."""
    return call(folder, "snakemake", "--dry-run", "--cores", "1", *options, "--configfile", "params/scale.yaml")


def make_results(folder: Path, params: Params) -> None:
    """Every result as a sparse file, manifests of the shards as they are, and Snakemake's note of them."""
    listed = call(folder, "snakemake", "--summary", "--configfile", "params/scale.yaml").text
    outputs = [line.split("\t")[0] for line in listed.splitlines() if line.startswith("results/")]
    for path in (folder / name for name in outputs):
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            with open(path, "wb") as file:
                file.truncate(600_000_000 if path.suffix == ".tar" else 2_000)
    for beta in BETAS:
        for shard in params.scenes.shards:
            frames = synscapes.shard_frames(shard, params.scenes.shard_frames)
            lines = [(synscapes.foggy_name(frame, beta), 1_200_000, f"{frame:064x}") for frame in frames]
            manifest = Path(f"results/fog/beta_{beta}/{shard}.csv")
            write_csv(folder / manifest, ("name", "size", "sha256"), lines)
            record = {"command": ["foggy", "fog"], "inputs": {}, "outputs": {str(manifest): sha256(folder / manifest)}}
            (folder / manifest).with_suffix(".run.json").write_text(json.dumps(record))
    call(folder, "snakemake", "--touch", "--forceall", "--cores", "1", "--configfile", "params/scale.yaml")


def measure(frames: int) -> dict[str, Call | int]:
    """All measurements at one size."""
    with tempfile.TemporaryDirectory(prefix="foggy-scale-") as name:
        folder = clone(Path(name))
        params = plan(folder, frames)
        foggy = (sys.executable, "-m", "foggy_synscapes")
        option = ("--params", "params/scale.yaml")
        call(folder, *foggy, "scenes", "--dataset", "synscapes", *option)
        found: dict[str, Call | int] = {"refresh": call(folder, *foggy, "scenes", "--dataset", "synscapes", *option)}
        found["planned"] = planned(folder)
        found["jobs"] = int(re.search(r"^total +(\d+)$", found["planned"].text, re.MULTILINE)[1])
        (folder / "params.yaml").write_bytes((folder / "params/scale.yaml").read_bytes())
        call(folder, "git", "init", "--quiet")
        found["dvc status"] = call(folder, "dvc", "status")
        # Without --force DVC stops at the first input that an earlier step has yet to make.
        found["dvc repro"] = call(folder, "dvc", "repro", "--dry", "--force")
        found["filter"] = call(folder, *foggy, "filter", *option)
        make_results(folder, params)
        found["subset"] = call(folder, *foggy, "subset", "--row", "FS-24500", *option)
        call(folder, "snakemake", "--touch", "--forceall", "--cores", "1", "--configfile", "params/scale.yaml")
        found["made"] = planned(folder)
        if "Nothing to be done" not in found["made"].text:
            raise SystemExit(f"a dry run after everything was made plans jobs:\n{found['made'].text[-4000:]}")
        return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, nargs="+", default=[200, 1000, 5000, 25000], help="sizes to plan")
    options = parser.parse_args()
    results = {frames: measure(frames) for frames in sorted(options.frames)}
    timed = ["planned", "made", "dvc status", "dvc repro", "refresh", "filter", "subset"]
    rows = [
        (
            f"{frames * len(BETAS):,}",
            found["jobs"],
            *(f"{found[name].seconds:.1f} s, {found[name].megabytes:.0f} MB" for name in timed),
        )
        for frames, found in results.items()
    ]
    print(table(("foggy images", "jobs", *timed), rows))
    smallest, largest = min(results), max(results)
    late = []
    for name in ("planned", "made"):
        found = results[largest][name]
        if found.seconds > SECONDS or found.megabytes > MEGABYTES:
            late.append(
                f"{name}: {found.seconds:.1f} s and {found.megabytes:.0f} MB, targets {SECONDS} and {MEGABYTES}"
            )
        growth = found.seconds / results[smallest][name].seconds
        if growth > largest / smallest:
            late.append(f"{name}: {growth:.1f} times the time for {largest / smallest:.0f} times the images")
    if late:
        raise SystemExit("\n".join(late))


if __name__ == "__main__":
    main()
