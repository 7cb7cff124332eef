"""What each way of installing brings, and whether the wheel works by itself: `make doors`.

    python tests/long/doors.py [DOOR...] [--torch cpu]

Builds the wheel, installs it with each extra into an empty environment from the index that pip is set up for, holds the
packages against tests/helpers/doors.json, and prints their number and size. In the environment without an extra, fog
and scores are then computed on generated frames in an empty folder, by the commands and from Python. Ends with status
77, saying why, where pip reaches no index.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "helpers"))

from doors import BARE, MOST_MEGABYTES, MOST_PACKAGES, ROOT, canonical, held, without_cuda

OWN = {"foggy-synscapes", "pip"}
NO_INDEX = 77
TORCH = "https://download.pytorch.org/whl/"
# Runs in the new environment, which has nothing of the repository.
TRY = """\
import json, subprocess, sys
from pathlib import Path
import numpy as np
import foggy_synscapes
from foggy_synscapes.io.images import encode_depth, encode_png, read_rgb

assert "site-packages" in foggy_synscapes.__file__, foggy_synscapes.__file__
foggy = str(Path(sys.executable).with_name("foggy"))
rng = np.random.default_rng(0)
image, depth = rng.integers(0, 256, (60, 90, 3), np.uint8), (2 + 90 * rng.random((60, 90))).astype(np.float32)
ids = rng.integers(0, 19, (60, 90)).astype(np.uint8)
for folder in ("rgb", "depth", "labels", "predictions"):
    Path(folder).mkdir()
Path("rgb/street.png").write_bytes(encode_png(image))
Path("depth/street.exr").write_bytes(encode_depth(depth))
for folder in ("labels", "predictions"):
    Path(folder, "street.png").write_bytes(encode_png(ids))
camera = dict(fx=100.0, fy=100.0, u0=45.0, v0=30.0, resx=90, resy=60)
Path("camera.json").write_text(json.dumps({"camera": {"intrinsic": camera}}))
paths = ["--rgb", "rgb", "--depth", "depth", "--camera", "camera.json", "--out", "out"]
subprocess.run([foggy, "fog", *paths, "--beta", "0.01"], check=True)
folders = ["--predictions", "predictions", "--labels", "labels", "--encoding", "trainIds"]
subprocess.run([foggy, "evaluate", *folders], check=True)
refused = subprocess.run([foggy, "networks"], capture_output=True, text=True, check=False)
assert refused.returncode == 1 and "pip install 'foggy-synscapes[" in refused.stderr, refused.stderr
written = read_rgb(Path("out/beta_0.01/foggy_img/street_beta_0.01.png"))
made = foggy_synscapes.fog("rgb/street.png", "depth/street.exr", beta=0.01, camera=foggy_synscapes.Camera(**camera))
assert np.array_equal(made, written)
assert foggy_synscapes.score("predictions", "labels", encoding="trainIds")["mean_iou"]["annotated"] == 100.0
"""


def main() -> int:
    """Measure the doors; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("doors", nargs="*", metavar="DOOR", help=f"of {', '.join(held())} (default: all)")
    parser.add_argument("--torch", metavar="BUILD", help="PyTorch's build, e.g. cpu (default: that of pip's index)")
    options = parser.parse_args()
    unknown = set(options.doors) - held().keys()
    if unknown:
        parser.error(f"{sorted(unknown)[0]}: there are {', '.join(held())}")
    with tempfile.TemporaryDirectory(prefix="foggy doors ") as place:
        folder = Path(place)
        built = pip(sys.executable, "wheel", "--no-deps", "--wheel-dir", str(folder), str(source(folder / "source")))
        if built.returncode:
            return no_index(built.stderr)
        (wheel,) = folder.glob("*.whl")
        print("| door | packages | MB |\n|---|---|---|", flush=True)
        wrong = []
        for door in options.doors or held():
            status = measure(door, wheel, folder / door, options.torch, wrong)
            if status:
                return status
    print("\n".join(wrong) or "doors: each installs what it is held to")
    return 1 if wrong else 0


def source(folder: Path) -> Path:
    """A copy of what the wheel is built of: the build leaves files beside it, which a later one would take in."""
    leave = shutil.ignore_patterns("__pycache__", "*.egg-info")
    shutil.copytree(ROOT / "src", folder / "src", ignore=leave)
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, folder)
    return folder


def measure(door: str, wheel: Path, folder: Path, torch: str | None, wrong: list[str]) -> int:
    """Install a door into an empty environment, print a line, and note in `wrong` what is not as it is held to be."""
    venv.create(folder, with_pip=True)
    python = folder / "bin/python"
    extra = "" if door == BARE else f"[{door}]"
    index = ["--extra-index-url", TORCH + torch] if torch else []
    installed = pip(python, "install", *index, f"foggy-synscapes{extra} @ {wheel.as_uri()}")
    if installed.returncode:
        return no_index(installed.stderr)
    listed = subprocess.run(
        [python, "-m", "pip", "list", "--format", "json"], capture_output=True, text=True, check=True
    )
    names = {canonical(each["name"]) for each in json.loads(listed.stdout)} - OWN
    # setuptools comes with the environment of some Pythons, and then is no package of the door.
    names -= {"setuptools"} - set(held()[door])
    size = sum(path.lstat().st_size for path in folder.glob("lib/*/site-packages/**/*") if not is_pips(path, folder))
    megabytes = size / 1e6
    print(f"| {door} | {len(names)} | {megabytes:.0f} |", flush=True)
    if without_cuda(names) != held()[door]:
        wrong.append(f"{door}: not as held: {sorted({*without_cuda(names)} ^ {*held()[door]})}")
    if door == BARE:
        if len(names) > MOST_PACKAGES or megabytes > MOST_MEGABYTES:
            wrong.append(f"{door}: {len(names)} packages, {megabytes:.0f} MB")
        empty = folder.with_name("empty folder")
        empty.mkdir()
        environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        tried = subprocess.run([python, "-c", TRY], cwd=empty, env=environment, check=False)
        if tried.returncode:
            wrong.append(f"{door}: fog and scores do not work in an empty folder")
    return 0


def is_pips(path: Path, folder: Path) -> bool:
    """Whether a file belongs to what an empty environment has."""
    return path.relative_to(folder).parts[3].partition("-")[0] in ("pip", "setuptools", "_distutils_hack")


def pip(python: str | Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run pip of an environment."""
    call = [python, "-m", "pip", "--disable-pip-version-check", "--quiet", *arguments]
    return subprocess.run(call, capture_output=True, text=True, check=False)


def no_index(told: str) -> int:
    """Say that nothing could be installed, and why."""
    print(f"doors: pip could not install; is an index within reach?\n{told.strip()}", file=sys.stderr)
    return NO_INDEX


if __name__ == "__main__":
    sys.exit(main())
