"""How far two folders of Foggy Cityscapes are apart, such as one that was made here and one that was downloaded."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.images import read_rgb
from foggy_synscapes.io.progress import progress

IMAGES = "leftImg8bit_foggy*/*/*/*.png"


@dataclass(frozen=True)
class Comparison:
    """What images of the same names in two folders differ by.

    images, alone : how many are in both, and in one only
    different, beyond : shares of pixels with any channel that differs, and by more than one level
    means : mean level of either folder; largest : difference in levels
    """

    images: int
    alone: int
    different: float
    beyond: float
    means: tuple[float, float]
    largest: int

    def __str__(self) -> str:
        means = f"{self.means[0]:.2f} and {self.means[1]:.2f}"
        return (
            f"{self.images} images in both, {self.alone} in one only; {self.different:.3%} of the pixels differ, "
            f"{self.beyond:.3%} by more than 1 level, at most by {self.largest}; mean level {means}"
        )


def compare(first: Path, second: Path) -> Comparison:
    """Compare the images of both folders that have the same path from leftImg8bit_foggy on.

    Raises FoggyError if they share none, or two of one name differ in size.
    """
    one, other = _images(first), _images(second)
    both = sorted(one.keys() & other.keys())
    if not both:
        raise FoggyError(
            f"{first} and {second}: share no image leftImg8bit_foggy*/SPLIT/CITY/NAME.png ({len(one)} and {len(other)} "
            "such images). Are they of the same frames, betas and refinement?"
        )
    pixels = different = beyond = largest = 0
    sums = np.zeros(2)
    for name in progress(both, "compare", unit="image"):
        ours, theirs = (read_rgb(images[name]).astype(np.int16) for images in (one, other))
        if ours.shape != theirs.shape:
            raise FoggyError(f"{one[name]} and {other[name]}: of different size. Are they of the same frame?")
        apart = np.abs(ours - theirs).max(axis=2)
        pixels += apart.size
        different += int(np.count_nonzero(apart))
        beyond += int(np.count_nonzero(apart > 1))
        largest = max(largest, int(apart.max()))
        sums += ours.mean() * apart.size, theirs.mean() * apart.size
    mean, other_mean = (float(value) for value in sums / pixels)
    alone = len(one.keys() ^ other.keys())
    return Comparison(len(both), alone, different / pixels, beyond / pixels, (mean, other_mean), largest)


def _images(folder: Path) -> dict[str, Path]:
    if not folder.is_dir():
        raise FoggyError(f"{folder}: no such folder")
    return {"/".join(path.parts[-4:]): path for path in folder.rglob(IMAGES)}
