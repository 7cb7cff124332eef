"""unpack: plain folders of images from shards."""

import argparse
from pathlib import Path

from foggy_synscapes.datasets.uris import RECIPE
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.atomic import write_bytes
from foggy_synscapes.io.hashing import checked
from foggy_synscapes.io.progress import progress
from foggy_synscapes.io.shards import Shard, read_manifest

HELP = "Unpack shards into folders: results/fog/beta_B/0000.tar gives DIR/beta_B/foggy_img/00001_beta_B.png."


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this step."""
    parser.add_argument(
        "shards", type=Path, nargs="+", metavar="SHARD", help="shard, e.g. results/fog/beta_0.005/0000.tar"
    )
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="where to make the folders")


def run(args: argparse.Namespace) -> None:
    """Run the step from the command line."""
    unpack(args.shards, args.out)


def unpack(shards: list[Path], out: Path) -> None:
    """Write the images of shards to `out`/BETA/foggy_img, as `foggy fog` alone would.

    Raises FoggyError if a shard is missing or damaged, or a member is not as its manifest says.
    """
    count = 0
    for path in shards:
        folder = out / path.absolute().parent.name / "foggy_img"
        manifest = read_manifest(path.with_suffix(".csv"))
        with Shard(path) as shard:
            if shard.names() != [member.name for member in manifest]:
                raise FoggyError(
                    f"{path}: its members are not those of {path.with_suffix('.csv').name}. Make it again."
                )
            if any(member.name.endswith(RECIPE) for member in manifest):
                raise FoggyError(
                    f"{path}: holds recipes, not images (fog.render is on_the_fly). Set it to ahead and make the "
                    "shard again, or render the frames by `foggy fog --synscapes`."
                )
            for member in progress(manifest, f"unpack {path.name}"):
                write_bytes(
                    folder / member.name, checked(shard.read(member.name), member.sha256, f"{path}#{member.name}")
                )
                count += 1
    print(f"unpack: {count} images in {out}")
