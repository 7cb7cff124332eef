"""How fast depth is completed from stereo and fog made of it: python benchmarks/stereo.py [--rounds 5] [--frames 6]

One frame of 2048 x 1024: the real one where --samples (or ../shared/data) has it, otherwise a generated street.
  completion    disparity to depth at every pixel; the random stream is that of the published code
  a beta        transmittance, refined, and the foggy image in 8 bits; what is prepared once a frame is told beside it
  memory        peak of the command on one frame
  speed-up      of the command by 2 processes over 1 on so many copies of the frame, its start taken off; needs idle
                processors, and cannot gain more than plain arithmetic does on them
Beside each CPU time stands its ratio to the target, and to the published code's under GNU Octave where the samples tell
it (measured elsewhere: an order of magnitude, no more). CPU time of one thread, medians; loops are compiled before.
"""

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests/helpers"))

from fog import PROGRAM, both_processors
from measured_frames import cpu
from stereo_frames import content, write

from foggy_synscapes.datasets import cityscapes
from foggy_synscapes.depth import annotation, refinement
from foggy_synscapes.depth.completion import SEED, complete
from foggy_synscapes.fog.airlight import estimate
from foggy_synscapes.fog.geometry import rays
from foggy_synscapes.frames.stereo import of_path, read_views
from foggy_synscapes.io.images import read_grey16

SCENE = "train/dusseldorf/dusseldorf_000020_000019"
SIZE = (1024, 2048)
BETAS = (0.005, 0.01, 0.02)
COMPLETION, GUIDED, BILATERAL, MEMORY, BY_TWO = 3.0, 0.5, 1.5, 600, 1.8  # targets: CPU s a frame, a beta; MB; times
PUBLISHED = {"completion": "depth_total", "guided": "gf2", "bilateral": "dbf_dbf2"}
"""Entries of the published code's timing: wall and CPU seconds."""


def frame(root: Path, samples: Path) -> dict[str, Path]:
    """Files of the frame, by what they are."""
    real = samples / "cityscapes"
    if not (real / cityscapes.right(SCENE)).is_file():
        write(root, SCENE, content(0, SIZE))
        real = root
    kinds = ("image", "right", "disparity", "camera", "instances")
    return {kind: real / getattr(cityscapes, kind)(SCENE) for kind in kinds}


def median(work: Callable[[], Any], rounds: int) -> float:
    work()  # compiles, and finds its memory
    return statistics.median(cpu(work) for _ in range(rounds))


def copies(root: Path, files: dict[str, Path], count: int) -> None:
    """The same frame under so many names."""
    for number in range(count):
        for kind, path in files.items():
            link = root / getattr(cityscapes, kind)(f"train/copies/copies_{number:06d}_000019")
            link.parent.mkdir(parents=True, exist_ok=True)
            link.symlink_to(path.resolve())


def command(root: Path, out: Path, refine: str, processes: int) -> tuple[float, int, float]:
    """Wall seconds, images, and peak MB of the first process of the command."""
    options = ["--layout", "cityscapes", "--root", str(root), "--refine", refine, "--beta", "0.01", "--out", str(out)]
    call = [sys.executable, "-c", PROGRAM, "fog", *options, "--jobs", str(processes)]
    started = time.perf_counter()
    done = subprocess.run(call, capture_output=True, text=True, check=True)
    seconds = time.perf_counter() - started
    return seconds, len(list(out.rglob("*.png"))), int(done.stderr.split()[-1]) / 1000


def speed_up(folder: Path, files: dict[str, Path], count: int) -> float:
    """Frames per second of two processes over one, by the frames that a longer run has more."""
    copies(folder / "few", files, 2)
    copies(folder / "many", files, 2 + count)
    took = {
        (name, processes): command(folder / name, folder / f"{name}{processes}", "guided", processes)[0]
        for processes in (1, 2)
        for name in ("few", "many")
    }
    return (took["many", 1] - took["few", 1]) / (took["many", 2] - took["few", 2])


def line(
    name: str, value: float, unit: str, target: float, published: float | None = None, least: bool = False
) -> None:
    good, bound = (value >= target, "least") if least else (value <= target, "most")
    said = f"{value / target:5.2f} of the {bound} allowed {target:g}: {'good' if good else 'NOT REACHED'}"
    faster = f"; {published / value:.0f} times as fast as published" if published else ""
    print(f"{name:<34}{value:8.2f} {unit:<5}  {said}{faster}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5, help="times that each part is measured (default: 5)")
    parser.add_argument("--frames", type=int, default=6, help="more frames of the longer run (default: 6; 0: skip it)")
    parser.add_argument("--samples", type=Path, default=Path("../shared/data"), help="folder of the real samples")
    args = parser.parse_args()
    timing = args.samples / "stereo_reference/dusseldorf/timing_wall_cpu_seconds.json"
    published = json.loads(timing.read_text()) if timing.is_file() else {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        files = frame(folder / "street", args.samples)
        views = read_views(*(of_path(files[kind]) for kind in ("image", "right", "disparity", "camera")))
        left, rounds = views.left, args.rounds
        found = complete(left, views.right, views.stored, views.stereo, SEED)
        print(f"{left.shape[1]} x {left.shape[0]}, {found.segments.draws / 1e6:.0f} million draws")

        def took(part: str) -> float | None:
            return published[PUBLISHED[part]][1] if published else None

        seconds = median(lambda: complete(left, views.right, views.stored, views.stereo, SEED), rounds)
        line("completion, CPU a frame", seconds, "s", COMPLETION, took("completion"))
        light, lines = estimate(left).levels, rays(views.stereo.camera)
        labels = annotation.labels(read_grey16(files["instances"]))
        for part, prepare, target in (
            ("guided", lambda: refinement.guided(left), GUIDED),
            ("bilateral", lambda: refinement.bilateral(left, labels), BILATERAL),
        ):
            refine = prepare()

            def fog(beta: float, refine: refinement.Refine = refine) -> np.ndarray:
                return refinement.composite(left, refine(refinement.initial(found.depth, lines, beta)), light)

            seconds = statistics.mean(median(lambda beta=beta: fog(beta), rounds) for beta in BETAS)
            line(f"{part}, CPU a beta", seconds, "s", target, took(part))
            print(f"{'  once a frame':<34}{median(prepare, rounds):8.2f} s")
        copies(folder / "one", files, 1)
        for part in ("guided", "bilateral"):
            line(f"{part}, peak memory", command(folder / "one", folder / part, part, 1)[2], "MB", MEMORY)
        if args.frames:
            line("2 processes over 1", speed_up(folder, files, args.frames), "times", BY_TWO, least=True)
            print(f"{'  of plain arithmetic here':<34}{both_processors():8.2f} times")


if __name__ == "__main__":
    main()
