"""Whether a killed training goes on to the same bytes: python tests/long/train_kills.py [--kills 20] [--row FS-498]

In the project's folder, after a run of it. Each network is trained anew in a scratch copy of what the row needs, killed
at random moments (SIGKILL) and started again, with no, one or two loader workers in turn, until it ends; its model
and curve are then compared with those of the run, byte for byte.
"""

import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import yaml

from foggy_synscapes.io.hashing import sha256
from foggy_synscapes.params.training import BASELINE

NETWORKS = ("bisenet", "refinenet")
COMPARED = ("model.safetensors", "curves.csv")


def scratch_copy(folder: Path, network: str, row: str) -> None:
    """What a training of the row reads; images are linked."""
    for name in ("scenes", "fog", "subset"):
        (folder / "results").mkdir(exist_ok=True)
        (folder / "results" / name).symlink_to(Path("results", name).resolve())
    baseline = Path("results/train", network, BASELINE, "seed-0")
    if row != BASELINE:
        shutil.copytree(baseline, folder / baseline)
    for workers in (0, 1, 2):
        document = yaml.safe_load(Path("params.yaml").read_text())
        document["train"] |= {"workers": workers, "snapshot": 5}
        (folder / f"workers-{workers}.yaml").write_text(yaml.safe_dump(document, sort_keys=False))


def train(folder: Path, network: str, row: str, workers: int, killed_after: float | None) -> bool:
    """Train, or go on; True where the training ended before it would have been killed."""
    call = ["foggy", "train", "--network", network, "--row", row, "--seed", "0", "--params", f"workers-{workers}.yaml"]
    running = subprocess.Popen(call, cwd=folder, start_new_session=True, stdout=subprocess.DEVNULL)
    try:
        if running.wait(killed_after) != 0:
            sys.exit(f"{network} {row}: the training failed")
        return True
    except subprocess.TimeoutExpired:
        os.killpg(running.pid, signal.SIGKILL)
        running.wait()
        return False


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=20, help="of all networks together (default: 20)")
    parser.add_argument("--row", default="FS-498", help="row that is trained (default: FS-498)")
    parser.add_argument("--latest", type=float, default=12, help="seconds until the latest kill (default: 12)")
    options = parser.parse_args()
    moments, good = random.Random(0), True
    for network in NETWORKS:
        with tempfile.TemporaryDirectory() as name:
            folder, kills, starts = Path(name), 0, 0
            scratch_copy(folder, network, options.row)
            made = Path("results/train", network, options.row, "seed-0")
            while kills < options.kills // len(NETWORKS):
                if train(folder, network, options.row, starts % 3, moments.uniform(1, options.latest)):
                    good = good and same(folder, made, kills)
                    shutil.rmtree(folder / made)
                else:
                    kills += 1
                starts += 1
            train(folder, network, options.row, starts % 3, None)
            good = same(folder, made, kills) and good
    return 0 if good else 1


def same(folder: Path, made: Path, kills: int) -> bool:
    equal = all(sha256(folder / made / name) == sha256(made / name) for name in COMPARED)
    print(f"{made}: after {kills} kills {'the same bytes' if equal else 'OTHER BYTES'}", flush=True)
    return equal


if __name__ == "__main__":
    sys.exit(main())
