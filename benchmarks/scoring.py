"""How fast predictions are scored: python benchmarks/scoring.py [--pairs 48] [--repeat 3]

Pairs of 2048 x 1024 maps of trainIds are made in a temporary folder, then
  decoding      both PNGs of each pair are read and nothing else: the floor
  ours          what `foggy evaluate --predictions ... --labels ... --jobs N` does between start and report
  official      cityscapesscripts, without instance scores, on the same maps in labelIds
once on files as other programs write them (Pillow), once on files as they are written here, which decode faster.
Times are the best of the repeats, taken in turn so that all meet the same machine. Peak memory is that of this process
after it scored all pairs, and after it scored three times as many.
"""

import argparse
import io
import resource
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from cityscapesscripts.evaluation import evalPixelLevelSemanticLabeling as scorer
from PIL import Image

from foggy_synscapes.datasets.predictions import count_pairs
from foggy_synscapes.io.images import encode_png, read_ids
from foggy_synscapes.labels import IGNORE, from_train_ids
from foggy_synscapes.scoring.iou import iou

SHAPE = 1024, 2048
OVER_DECODING, FASTER = 1.4, 5.0  # targets, of one process


def scene(rng: np.random.Generator) -> np.ndarray:
    """A map of trainIds in blobs of all sizes, with about as many edges as labelled streets have."""
    rows, columns = np.ogrid[: SHAPE[0], : SHAPE[1]]
    ids = np.zeros(SHAPE, np.uint8)
    for _ in range(400):
        row, column = rng.integers(SHAPE[0]), rng.integers(SHAPE[1])
        high, wide = rng.integers(4, 180), rng.integers(4, 250)
        top, left = max(0, row - high), max(0, column - wide)
        down, across = (rows[top : row + high] - row) / high, (columns[:, left : column + wide] - column) / wide
        inside = down**2 + across**2 < 1
        ids[top : row + high, left : column + wide][inside] = rng.integers(19)
    return ids


def as_others_do(ids: np.ndarray) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(ids).save(buffer, "PNG")
    return buffer.getvalue()


def make(folder: Path, pairs: int) -> list[tuple[str, str]]:
    """Write the maps; predictions are the labels displaced by a few pixels, so that edges differ."""
    rng = np.random.default_rng(0)
    for side in ("labels", "predictions"):
        for kind in ("pillow", "own", "official"):
            (folder / kind / side).mkdir(parents=True)
    for number in range(pairs):
        labels = scene(rng)
        predictions = np.roll(labels, rng.integers(-4, 5, 2), (0, 1))
        labels[-40:] = IGNORE
        for side, ids in (("labels", labels), ("predictions", predictions)):
            name = f"{side}/{number:03d}.png"
            (folder / "pillow" / name).write_bytes(as_others_do(ids))
            (folder / "own" / name).write_bytes(encode_png(ids))
            (folder / "official" / name).write_bytes(as_others_do(from_train_ids(ids)))
    return [(f"{number:03d}.png", f"{number:03d}.png") for number in range(pairs)]


def decode(folder: Path, pairs: list[tuple[str, str]]) -> None:
    for label, prediction in pairs:
        read_ids(folder / "labels" / label), read_ids(folder / "predictions" / prediction)


def ours(folder: Path, pairs: list[tuple[str, str]], jobs: int) -> float:
    tally = count_pairs(folder / "labels", folder / "predictions", pairs, jobs)
    return float(np.mean(iou(tally.matrix("trainIds", "trainIds"))))


def official(folder: Path, pairs: list[tuple[str, str]]) -> float:
    sides = [[str(folder / side / name) for name, _ in pairs] for side in ("predictions", "labels")]
    return scorer.evaluateImgLists(*sides, scorer.args)["averageScoreClasses"]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=48, help="number of pairs (default: 48)")
    parser.add_argument("--repeat", type=int, default=3, help="repeats, of which the best counts (default: 3)")
    options = parser.parse_args()
    scorer.args.evalInstLevelScore = scorer.args.JSONOutput = False
    scorer.args.quiet = True
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        pairs = make(folder, options.pairs)
        ways = {"official": lambda: official(folder / "official", pairs)}
        for kind in ("pillow", "own"):
            ways[f"decoding, {kind}"] = lambda kind=kind: decode(folder / kind, pairs)
            for jobs in (1, 2):
                ways[f"ours, {kind}, {jobs}"] = lambda kind=kind, jobs=jobs: ours(folder / kind, pairs, jobs)
        best, scores = dict.fromkeys(ways, float("inf")), {}
        for _ in range(options.repeat):
            for way, work in ways.items():
                start = time.perf_counter()
                scores[way] = work()
                best[way] = min(best[way], (time.perf_counter() - start) / len(pairs))
        peaks = []
        for times in (1, 3):
            ours(folder / "pillow", pairs * times, 1)
            peaks.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
    for way, seconds in best.items():
        print(f"{way:<20} {1000 * seconds:8.2f} ms a pair")
    good = all(abs(score - scores["official"]) < 1e-12 for score in scores.values() if score is not None)
    print(f"mean IoU of all ways equal: {good}")
    for kind in ("pillow", "own"):
        one, two = best[f"ours, {kind}, 1"], best[f"ours, {kind}, 2"]
        over, faster = one / best[f"decoding, {kind}"], best["official"] / one
        print(f"{kind}: {over:.2f} x decoding, {faster:.1f} x as fast as official")
        print(f"{kind}: 2 processes {one / two:.2f} x as fast as 1")
        if kind == "pillow":
            good = good and over <= OVER_DECODING and faster >= FASTER
    print(f"peak memory: {peaks[0]:.0f} MB for {len(pairs)} pairs, {peaks[1]:.0f} MB after three times as many")
    targets = f"targets (pillow: at most {OVER_DECODING} x decoding, at least {FASTER} x as fast as official)"
    print(f"{targets}: {'met' if good else 'MISSED'}")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
