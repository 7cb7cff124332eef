"""What the full experiment costs, from the cost of one image: python benchmarks/budget.py [--params FILE]

Lengths, validations, policies and lists are those of the params, multiply-adds of an image those of the networks at
the params' size, as `foggy plan` counts them; a step backwards counts as two forwards. Disk and the time of fog are
those of one real frame, times the number of frames. `docs/scale.md` and the README quote what comes of
params/paper.yaml.
"""

import argparse
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests/helpers"))

from clones import ROOT, table

from foggy_synscapes.params import Params, load
from foggy_synscapes.planning import costs as planned

CPU = 0.055  # seconds of CPU time that a frame's five foggy images take
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


def costs(params: Params) -> list[Cost]:
    """What each row of each network costs: a model that is not trained here is evaluated all the same."""
    trained = {(each.network, each.row): each for each in params.trainings()}
    seeds, found = len(params.train.seeds), []
    for network in params.train.networks:
        tested = sum(planned.evaluation(params, network, test_set) for test_set in params.evaluate.test_sets)
        for row in params.subset.rows():
            each = trained.get((network, row))
            spent = (0, 0.0, 0.0)
            if each is not None:
                spent = each.images_seen, planned.steps(params, each), planned.validations(params, each)
            found.append(Cost(network, row, *(seeds * value for value in (*spent, tested))))
    return found


def report(params: Params) -> str:
    """The table of all rows, and what they come to, as docs/scale.md has it."""
    found = costs(params)
    rows = [(each.network, each.row, f"{each.images:,}", *map(_unit, each[3:]), f"{each.hours:.1f}") for each in found]
    heads = ("network", "row", "images", "steps, 10^15", "validation, 10^15", "evaluation, 10^15", "h at 10^13 / s")
    whole = sum(each.steps + each.validations + each.evaluations for each in found)
    frames = params.fog.frames.first + params.fog.frames.last
    foggy, image = frames * len(params.fog.betas), planned.FOGGY * planned.pixels(params, "synscapes")
    return "\n".join(
        [
            table(heads, rows),
            "",
            f"training and evaluation: {_unit(whole)} x 10^15 multiply-adds, {hours(found):.0f} h at 10^13 / s",
            f"fog: {foggy:,} images, {foggy * image / 1e9:.0f} GB, at most {frames * CPU / 60:.0f} min of CPU time",
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
