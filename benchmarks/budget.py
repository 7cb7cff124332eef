"""What the full experiment costs, from the cost of one image: python benchmarks/budget.py [--params FILE]

Counts come from the params; multiply-adds of an image from the networks at their published size; a step
backwards counts as two forwards. Disk and the time of fog are those of one real frame, times the number of frames.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests/helpers"))

from clones import ROOT, table

from foggy_synscapes.networks.catalogue import catalogue
from foggy_synscapes.params import Params, load
from foggy_synscapes.subsets import KINDS
from foggy_synscapes.subsets.kind import FOG

SYNSCAPES, CITYSCAPES = 1440 * 720, 2048 * 1024  # pixels of an image
UNIT = 1024 * 512  # pixels of the image that the multiply-adds are for
PNG, CPU = 1.2e6, 0.055  # bytes of a foggy image; seconds of CPU time that a frame's five foggy images take
GPU = 10e12  # multiply-adds a second that the last column supposes; put in what yours sustains


def entries(params: Params, row: str) -> tuple[list[int], int]:
    """Pixels of each validation image of a row's list, and how many images it trains on."""
    entry, foggy = params.subset.rows()[row], FOG in KINDS[params.subset.kind(row)].reads
    train, validation = entry.counts()
    # What a list holds beyond its entry's own counts are the Foggy Cityscapes images of a mix.
    mixed = validation - entry.validation
    return [SYNSCAPES if foggy else CITYSCAPES] * entry.validation + [CITYSCAPES] * mixed, train


def training(params: Params, network: str, row: str) -> tuple[int, float, float] | None:
    """Images that a training draws, multiply-adds of its steps and of its validations; None if nothing trains."""
    settings = params.train.network(network)
    policy = settings.fine_tuning if row in params.train.from_baseline else settings.baseline
    if policy is None:
        return None
    span = params.train.rows[row] if row in params.train.from_baseline else policy
    pixels, listed = entries(params, row)
    steps = span.length.steps(listed, policy.batch)
    validations = steps // span.validate_.steps(listed, policy.batch)
    cost = next(each for each in catalogue() if each["name"] == network)["multiply_adds_1024x512"] / UNIT
    images = steps * policy.batch
    return images, 3 * images * policy.crop[0] * policy.crop[1] * cost, validations * sum(pixels) * cost


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--params", type=Path, default=ROOT / "params/paper.yaml", help="params file")
    params = load(parser.parse_args().params)
    rows, total = [], 0.0
    for network in params.train.networks:
        for row in params.subset.rows():
            found = training(params, network, row)
            if found is not None:
                images, steps, validations = (len(params.train.seeds) * each for each in found)
                total += steps + validations
                hours = (steps + validations) / GPU / 3600
                rows.append(
                    (network, row, f"{images:,}", f"{steps / 1e15:.1f}", f"{validations / 1e15:.1f}", f"{hours:.1f}")
                )
    print(table(("network", "row", "images", "steps, 10^15", "validation, 10^15", "hours at 10^13 / s"), rows))
    frames = params.fog.frames.first + params.fog.frames.last
    betas = len(params.fog.betas)
    print(f"\ntraining: {total / 1e15:.0f} x 10^15 multiply-adds, {total / GPU / 3600:.0f} h at 10^13 a second")
    foggy = frames * betas
    print(f"fog: {foggy:,} images, {foggy * PNG / 1e9:.0f} GB, at most {frames * CPU / 60:.0f} min of CPU time")


if __name__ == "__main__":
    main()
