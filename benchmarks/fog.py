"""How fast fog is rendered: python benchmarks/fog.py [--frames 100] [--long 100] [--rounds 100] [--samples DIR]

Five foggy images of each 1440 x 720 frame, on the two real Synscapes samples where --samples (or ../shared/data) has
them, otherwise on generated frames that decode and encode about as fast (but zlib, in the plain version, takes half the
time on their noise: how much faster fog is than that version is judged on the real ones only).
  codecs        decoding image and depth, encoding the five foggy images, and nothing else: the floor
  fog           the same with airlight and fog: what `foggy fog` does with a frame between its files
  naive         plain float64 NumPy, read and written by OpenImageIO with its default compression
  images/s      of the command by 1 and 2 processes, its start taken off, files written and synced; needs idle
                processors, and cannot gain more than plain arithmetic does on them. Measured with files in memory
                (/dev/shm), and beside it on the disk of TMPDIR: there one process already has its files synced on a
                second processor, and the disk itself does not get faster by more processes
CPU time is this thread's; codecs and fog are measured in turn, so that both meet the same machine.
"""

import argparse
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests/helpers"))

from measured_frames import REAL, cpu, frames

from foggy_synscapes.camera import Camera
from foggy_synscapes.fog.airlight import GREY, estimate
from foggy_synscapes.frames import rendering
from foggy_synscapes.io.images import encode_png, read_depth, read_rgb
from foggy_synscapes.io.photographs import encode_photograph

BETAS = ["0.005", "0.01", "0.02", "0.03", "0.06"]
REPEATS = 5  # runs by 1 and by 2 processes in turn, of which the median counts
IN_MEMORY, FRAME_BYTES = Path("/dev/shm"), 8_000_000  # Linux; of five foggy images, more than they take
WARM = 20  # frames of the run whose time is taken off: processes start and load meanwhile
OVER_CODECS, OVER_NAIVE, BY_TWO, MEMORY = 1.10, 40, 1.8, 400  # targets: ratios and MB
# The peak of this program alone: what getrusage reports begins with the memory of the process that started it.
PROGRAM = """
import sys
from foggy_synscapes.cli import main
status = main(sys.argv[1:])
peak = next(line for line in open("/proc/self/status") if line.startswith("VmHWM:"))
print(peak.split()[1], file=sys.stderr)
raise SystemExit(status)
"""


def codecs(folder: Path, frame: int, foggy: list[np.ndarray], level: int) -> None:
    read_rgb(folder / f"img/rgb/{frame}.png")
    read_depth(folder / f"img/depth/{frame}.exr")
    for image in foggy:
        encode_png(image, level) if level else encode_photograph(image)


def fog(folder: Path, frame: int, camera: Camera, level: int) -> list[bytes]:
    paths = folder / f"img/rgb/{frame}.png", folder / f"img/depth/{frame}.exr"
    clear = rendering.read_clear(*paths, *map(str, paths))
    light, _ = rendering.airlight_of(clear.image, "keep")
    lines = rendering.rays_of(clear, camera, "camera", "paper")
    return list(rendering.foggy_pngs(clear, lines, light, BETAS, level))


def naive(folder: Path, frame: int, camera: Camera, out: Path) -> None:
    import OpenImageIO as oiio

    def read(path: Path, kind: str) -> np.ndarray:
        return oiio.ImageInput.open(str(path)).read_image(kind)

    image = read(folder / f"img/rgb/{frame}.png", "uint8").astype(np.float64) / 255
    depth = read(folder / f"img/depth/{frame}.exr", "float")[..., 0].astype(np.float64)
    dark = image.min(axis=2)
    padded = np.pad(dark, 7, constant_values=np.inf)
    for axis in (0, 1):
        padded = np.lib.stride_tricks.sliding_window_view(padded, 15, axis).min(axis=-1)
    ranked = np.argsort(-padded.ravel(order="F"), kind="stable")[:1037]
    colours = image.transpose(1, 0, 2).reshape(-1, 3)[ranked]
    grey = colours @ (np.array(GREY) / 1e9)
    light = colours[np.flatnonzero(grey == np.sort(grey)[grey.size // 2])[0]]
    y, x = np.mgrid[1 : camera.resy + 1, 1 : camera.resx + 1]
    distance = depth * np.sqrt((camera.fx**2 + (x - camera.u0) ** 2 + (y - camera.v0) ** 2) / camera.fx**2)
    for beta in BETAS:
        t = np.exp(-float(beta) * distance)[..., None]
        levels = np.clip(np.floor(255 * (t * image + (1 - t) * light) + 0.5), 0, 255).astype(np.uint8)
        writer = oiio.ImageOutput.create("image.png")
        writer.open(str(out / f"{beta}.png"), oiio.ImageSpec(camera.resx, camera.resy, 3, "uint8"))
        writer.write_image(levels)
        writer.close()


def both_processors() -> float:
    """How much more arithmetic two processes that share nothing do than one: what this machine has to give."""
    work = [sys.executable, "-c", "for _ in range(6): sum(range(10_000_000))"]
    times = []
    for count in (1, 2):
        started = time.perf_counter()
        for running in [subprocess.Popen(work) for _ in range(count)]:
            running.wait()
        times.append(time.perf_counter() - started)
    return 2 * times[0] / times[1]


def run(folder: Path, out: Path, count: int, *more: str) -> tuple[float, float]:
    """Seconds and peak MB of the command on so many frames."""
    options = [f"--ids=1-{count}", f"--camera={folder / 'camera.json'}", f"--out={out}", *more]
    betas = [f"--beta={beta}" for beta in BETAS]
    call = [sys.executable, "-c", PROGRAM, "fog", "--synscapes", str(folder), *options, *betas]
    started = time.perf_counter()
    done = subprocess.run(call, capture_output=True, text=True, check=True)
    seconds = time.perf_counter() - started
    shutil.rmtree(out)
    return seconds, int(done.stderr.split()[-1]) / 1000


def scaling(place: str, folder: Path, out: Path, count: int, level: int, target: bool) -> None:
    """Frames per second of the command by 1 and 2 processes: those that it takes longer for, without its start."""
    pairs = []
    for _ in range(REPEATS):
        seconds = {
            (processes, frames): run(folder, out / "rate", frames, f"--jobs={processes}", f"--png-level={level}")[0]
            for processes in (1, 2)
            for frames in (WARM, count)
        }
        pairs.append([5 * (count - WARM) / (seconds[n, count] - seconds[n, WARM]) for n in (1, 2)])
    for processes, rate in zip(("1 process", "2 processes"), np.median(pairs, axis=0), strict=True):
        line(f"images/s, {place}, {processes}", f"{rate:.1f}")
    gain = float(np.median([two / one for one, two in pairs]))  # of neighbours: the clock changes with the minutes
    line("  speed-up", f"{gain:.2f}", f"at least {BY_TWO}" if target else "", gain >= BY_TWO)


def line(name: str, value: str, target: str = "", good: bool = True) -> None:
    verdict = f"{target}: {'reached' if good else 'NOT REACHED'}" if target else ""
    print(f"{name:<46}{value:>16}   {verdict}".rstrip())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=100, help="frames of the runs of the command (default: 100)")
    parser.add_argument("--long", type=int, default=100, help="frames of the run whose memory counts (default: 100)")
    parser.add_argument("--rounds", type=int, default=100, help="times that codecs and fog are measured (default: 100)")
    parser.add_argument("--samples", type=Path, default=Path("../shared/data"), help="folder of the real samples")
    parser.add_argument("--png-level", type=int, choices=range(4), default=0, help="of `foggy fog` (default: 0)")
    args = parser.parse_args()
    level = args.png_level
    rendering.keep_memory()
    with tempfile.TemporaryDirectory() as name:
        folder, out = Path(name) / "frames", Path(name) / "out"
        out.mkdir()
        camera = frames(folder, max(args.frames, args.long), args.samples)
        foggy = {frame: [read_rgb(data) for data in fog(folder, frame, camera, level)] for frame in (1, 2)}
        floor, ours, faster = [], [], []
        for _ in range(args.rounds):
            floor.append(sum(cpu(lambda f=frame: codecs(folder, f, foggy[f], level)) for frame in foggy) / 2)
            ours.append(sum(cpu(lambda f=frame: fog(folder, f, camera, level)) for frame in foggy) / 2)
        for _ in range(REPEATS):  # afterwards: what it leaves in memory slows its neighbours
            slow = cpu(lambda: naive(folder, 1, camera, out))
            faster.append(slow / np.median([cpu(lambda: fog(folder, 1, camera, level)) for _ in range(5)]))
        light = estimate(read_rgb(folder / "img/rgb/1.png"))
        same = all(
            np.array_equal(read_rgb(out / f"{beta}.png"), image) for beta, image in zip(BETAS, foggy[1], strict=True)
        )
        over = float(np.median(np.array(ours) / np.array(floor)))
        line("codecs, CPU ms a frame", f"{1e3 * np.median(floor):.1f}")
        line("fog, CPU ms a frame", f"{1e3 * np.median(ours):.1f}")
        line("  over codecs", f"{over:.3f}", f"at most {OVER_CODECS}", over <= OVER_CODECS)
        line("naive, CPU ms a frame", f"{1e3 * slow:.0f}")
        times = float(np.median(faster))
        wanted = f"at least {OVER_NAIVE}" if (args.samples / REAL).is_dir() else ""
        line("  over fog", f"{times:.1f}", wanted, times >= OVER_NAIVE)
        line(f"  its pixels (airlight {light.levels})", "equal" if same else "DIFFERENT", "0 different", same)
        roomy = IN_MEMORY.is_dir() and shutil.disk_usage(IN_MEMORY).free > FRAME_BYTES * args.frames
        if roomy:
            with tempfile.TemporaryDirectory(dir=IN_MEMORY) as memory:
                scaling("files in memory", folder, Path(memory), args.frames, level, target=True)
        scaling("on disk", folder, out, args.frames, level, target=not roomy)
        line("  of plain arithmetic here", f"{both_processors():.2f}")
        few, many = (run(folder, out / f"m{count}", count)[1] for count in (10, args.long))
        line("peak memory, MB, 10 frames", f"{few:.0f}", f"under {MEMORY}", few < MEMORY)
        line(f"peak memory, MB, {args.long} frames", f"{many:.0f}", f"under {MEMORY}", many < MEMORY)


if __name__ == "__main__":
    main()
