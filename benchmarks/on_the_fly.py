"""What fog on the fly trades: python benchmarks/on_the_fly.py [--rounds 20] [--samples DIR]

The same 1440 x 720 frames as in benchmarks/fog.py, read as a training reads them:
  ahead        the foggy image decoded from its shard's PNG
  on the fly   the recipe composited from the clear image and its depth, and its pixels checked
CPU time of one thread, in turn, so that both meet the same machine; and the bytes on disk that one foggy image takes.
The clear images and depth that `on the fly` reads are there in any case.
"""

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests/helpers"))

from measured_frames import cpu, frames

from foggy_synscapes.datasets import synscapes
from foggy_synscapes.datasets.uris import Reader
from foggy_synscapes.frames import compositing, recipes, rendering
from foggy_synscapes.io.hashing import sha256
from foggy_synscapes.io.images import read_rgb

BETA = "0.005"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--rounds", type=int, default=20, help="times that each is measured on each frame (default: 20)"
    )
    parser.add_argument("--samples", type=Path, default=Path("../shared/data"), help="folder of the real samples")
    args = parser.parse_args()
    rendering.keep_memory()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        camera = frames(folder, 2, args.samples)
        reader = Reader({"synscapes": folder})
        made = []
        for frame in (1, 2):
            paths = synscapes.rgb(frame), synscapes.depth(frame)
            clear = rendering.read_clear(*(folder / path for path in paths), *paths)
            light, _ = rendering.airlight_of(clear.image, rendering.KEEP)
            index = {path: sha256(folder / path) for path in paths}
            recipe = recipes.write(clear, camera, "paper", light, BETA, frame, index)
            lines = rendering.rays_of(clear, camera, "camera", "paper")
            (png,) = rendering.foggy_pngs(clear, lines, light, [BETA], 0)
            same = np.array_equal(compositing.composite(recipe, reader.read, "recipe"), read_rgb(png))
            assert same, "other pixels on the fly"
            made.append((png, recipe))
        ahead, on_the_fly = [], []
        for _ in range(args.rounds):
            ahead += [cpu(lambda png=png: read_rgb(png)) for png, _ in made]
            on_the_fly += [cpu(lambda r=recipe: compositing.composite(r, reader.read, "recipe")) for _, recipe in made]
        for title, times, part in (("ahead", ahead, 0), ("on the fly", on_the_fly, 1)):
            size = sum(len(each[part]) for each in made) / len(made)
            print(f"{title:<12}{1e3 * np.median(times):6.1f} CPU ms an image{size / 1e3:10.1f} kB an image")
        print(f"ratio of times {np.median(on_the_fly) / np.median(ahead):.1f}; pixels equal")


if __name__ == "__main__":
    main()
