"""What the full experiment costs, from the cost of one image: python benchmarks/budget.py [--params FILE]

Lengths, validations, policies and lists are those of the params, multiply-adds of an image those of the networks at
their published size; a step backwards counts as two forwards. Disk and the time of fog are those of one real frame,
times the number of frames. `docs/scale.md` and the README quote what comes of params/paper.yaml.
"""

import argparse
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests/helpers"))

from clones import ROOT, table

from foggy_synscapes.networks.catalogue import catalogue
from foggy_synscapes.params import Params, load
from foggy_synscapes.subsets import KINDS
from foggy_synscapes.subsets.kind import FOG

SYNSCAPES, CITYSCAPES = 1440 * 720, 2048 * 1024  # pixels of an image
# Images of a test set, and pixels of each. Foggy Driving's are of many sizes; counted as if all had 1280 x 960.
TESTED = {"foggy_driving": (101, 1280 * 960), "foggy_zurich": (40, 1920 * 1080), "cityscapes": (500, CITYSCAPES)}
UNIT = 1024 * 512  # pixels of the image that the multiply-adds are for
PNG, CPU = 1.2e6, 0.055  # bytes of a foggy image; seconds of CPU time that a frame's five foggy images take
GPU = 10e12  # multiply-adds a second that the last column supposes; put in what yours sustains


class Cost(NamedTuple):
    """A row of a network, all its seeds: images drawn, multiply-adds of steps, of validations and of evaluations."""

    network: str
    row: str
    images: int
    steps: float
    validations: float
    evaluations: float

    @property
    def hours(self) -> float:
        """Hours at `GPU` multiply-adds a second."""
        return (self.steps + self.validations + self.evaluations) / GPU / 3600


def validated(params: Params, row: str) -> int:
    """Pixels of a row's validation list."""
    entry = params.subset.rows()[row]
    _, whole = entry.counts()
    foggy = FOG in KINDS[params.subset.kind(row)].reads
    # What a list holds beyond its entry's own counts are the Foggy Cityscapes images of a mix.
    return (SYNSCAPES if foggy else CITYSCAPES) * entry.validation + CITYSCAPES * (whole - entry.validation)


def costs(params: Params) -> list[Cost]:
    """What each row of each network costs: a model that is not trained here is evaluated all the same."""
    pixel = {each["name"]: each["multiply_adds_1024x512"] / UNIT for each in catalogue()}
    trained = {(each.network, each.row): each for each in params.trainings()}
    tested = sum(count * pixels for count, pixels in (TESTED[name] for name in params.evaluate.test_sets))
    found = []
    for network in params.train.networks:
        each_pixel = pixel[network] * len(params.train.seeds)
        for row in params.subset.rows():
            images, steps, looks = 0, 0, 0
            if (network, row) in trained:
                each = trained[network, row]
                images, looks = each.images_seen, each.validations
                steps = 3 * images * each.policy.crop[0] * each.policy.crop[1]
            looked = looks * validated(params, row)
            seen = images * len(params.train.seeds)
            found.append(Cost(network, row, seen, steps * each_pixel, looked * each_pixel, tested * each_pixel))
    return found


def report(params: Params) -> str:
    """The table of all rows, and what they come to, as docs/scale.md has it."""
    found = costs(params)
    rows = [(each.network, each.row, f"{each.images:,}", *map(_unit, each[3:]), f"{each.hours:.1f}") for each in found]
    heads = ("network", "row", "images", "steps, 10^15", "validation, 10^15", "evaluation, 10^15", "h at 10^13 / s")
    whole = sum(each.steps + each.validations + each.evaluations for each in found)
    frames = params.fog.frames.first + params.fog.frames.last
    foggy = frames * len(params.fog.betas)
    return "\n".join(
        [
            table(heads, rows),
            "",
            f"training and evaluation: {_unit(whole)} x 10^15 multiply-adds, {hours(found):.0f} h at 10^13 / s",
            f"fog: {foggy:,} images, {foggy * PNG / 1e9:.0f} GB, at most {frames * CPU / 60:.0f} min of CPU time",
        ]
    )


def hours(found: Iterable[Cost]) -> float:
    """Hours of all rows at `GPU` multiply-adds a second."""
    return sum(each.hours for each in found)


def _unit(multiply_adds: float) -> str:
    return f"{multiply_adds / 1e15:,.1f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--params", type=Path, default=ROOT / "params/paper.yaml", help="params file")
    print(report(load(parser.parse_args().params)))


if __name__ == "__main__":
    main()
