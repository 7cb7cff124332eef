"""Which frames a command fogs, and where their files are."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from foggy_synscapes.datasets import synscapes
from foggy_synscapes.errors import FoggyError, UsageError

IMAGES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".webp", ".ppm", ".tga", ".jp2")


@dataclass(frozen=True)
class Frame:
    """A frame's files: its id as written in tables and file names, and where image, depth and camera are read.

    The camera is a JSON file, or the depth file itself, whose header may hold it; `checksums` are the SHA-256 that its
    `files` must have, where they are known. Where `numbered`, its images are named as the published script names them.
    """

    id: str
    rgb: Path
    depth: Path
    camera: Path
    checksums: Sequence[str] = ()
    numbered: bool = False

    def files(self) -> tuple[Path, ...]:
        """All files that it is made of: image, depth and camera."""
        return self.rgb, self.depth, self.camera

    def name(self, beta: str) -> str:
        """File name of an image of this frame: its number in five digits, or else its id as it is.

        >>> Frame("12", Path(), Path(), Path(), numbered=True).name("0.01")
        '00012_beta_0.01.png'
        >>> Frame("0000000012", Path(), Path(), Path()).name("0.01")      # so that it pairs with its labels
        '0000000012_beta_0.01.png'
        """
        return synscapes.foggy_name(int(self.id), beta) if self.numbered else f"{self.id}_beta_{beta}.png"


def of_synscapes(root: Path, ids: str | None, camera: Path | None, in_depth: bool = False) -> list[Frame]:
    """Frames of a folder in the layout of Synscapes, by number; all that have an image where `ids` is None.

    Their cameras are those of `camera`, or with `in_depth` of the depth files' headers, or of the meta files.

    Raises
    ------
    UsageError
        If the folder is not there or `ids` cannot be understood.
    FoggyError
        If there is no frame at all.
    """
    folder = root / "img" / "rgb"
    if not folder.is_dir():
        raise UsageError(f"{folder}: no such folder; --synscapes names the folder that holds img/ and meta/")
    if ids is not None:
        numbers = parse_ids(ids)
    else:  # unpadded, as Synscapes names them: 01.png beside 1.png is another file, not another frame
        stems = [path.stem for path in folder.glob("*.png")]
        numbers = sorted(int(stem) for stem in stems if stem.isdecimal() and str(int(stem)) == stem)
    if not numbers:
        raise FoggyError(f"{folder}: holds no image N.png")
    frames = [
        Frame(
            str(n),
            root / synscapes.rgb(n),
            root / synscapes.depth(n),
            camera or root / synscapes.meta(n),
            numbered=True,
        )
        for n in numbers
    ]
    return [replace(frame, camera=frame.depth) for frame in frames] if in_depth else frames


def order(frame: str) -> tuple[int, int, str]:
    """Sorting key of ids: numbers by value, then names."""
    return (0, int(frame), frame) if frame.isdecimal() else (1, 0, frame)


def parse_ids(text: str) -> list[int]:
    """Numbers named by a list of numbers and ranges, sorted, each once.

    >>> parse_ids("7,1-3,2")
    [1, 2, 3, 7]

    Raises UsageError for anything else.
    """
    numbers: set[int] = set()
    for part in text.split(","):
        first, dash, last = (piece.strip() for piece in part.partition("-"))
        if not (first.isdecimal() and (last.isdecimal() if dash else True)):
            raise UsageError(f"--ids {text}: {part.strip()!r} is no number or range, expected e.g. 1-500 or 1,5,9-12")
        start, end = int(first), int(last if dash else first)
        if not start <= end < 10**7:
            raise UsageError(f"--ids {text}: the range {part.strip()} is empty or too long")
        numbers.update(range(start, end + 1))
    return sorted(numbers)
