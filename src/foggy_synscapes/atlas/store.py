"""The stored reference: scattered light of each cell as means over blocks of pixels, small enough to be shipped."""

import io
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from foggy_synscapes.atlas.cells import SIZE, Cell, cells
from foggy_synscapes.atlas.scenes import Scene, scene
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.atomic import write_bytes
from foggy_synscapes.io.files import read_bytes
from foggy_synscapes.io.hashing import sha256_bytes

BLOCK = 16
"""Pixels on each side of a block: its mean needs a 256th of the paths that a pixel needs for the same error."""
SEEDS, SAMPLES = 4, 4
"""Renders of each cell, with random numbers of their own, and paths per pixel in each."""
FILE = Path(__file__).with_name("reference.npz")
DIGEST = FILE.with_suffix(".sha256")
AGAIN = "Make it again: foggy atlas --render (with the extra `reference`)."


@dataclass(frozen=True)
class Scattered:
    """Scattered light of a cell: float64 (h, w, 3) of blocks, linear, and the mean standard error of a block."""

    mean: np.ndarray
    error: float


def blocks(values: np.ndarray) -> np.ndarray:
    """Means over blocks: (h, w, C) of (H, W, C), sides in whole blocks."""
    height, width = values.shape[:2]
    return values.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, -1).mean(axis=(1, 3))


def render(cell: Cell, threads: int = 1) -> Scattered:
    """Path-trace a cell; FoggyError where Mitsuba is not installed."""
    from foggy_synscapes.atlas.pathtracing import scattered

    found = [blocks(scattered(scene(cell.frame), cell, SAMPLES, seed, threads)) for seed in range(SEEDS)]
    return of_seeds(np.stack(found))


def of_seeds(found: np.ndarray) -> Scattered:
    """Mean and standard error of block means by seed, (S, h, w, 3)."""
    return Scattered(found.mean(axis=0), float(found.std(axis=0, ddof=1).mean() / np.sqrt(len(found))))


def write(found: Mapping[Cell, Scattered], file: Path = FILE) -> None:
    """Write the reference, and its SHA-256 beside it."""
    arrays = {cell.name: one.mean.astype(np.float16) for cell, one in found.items()}
    arrays["errors"] = np.array([one.error for one in found.values()], np.float32)
    arrays["frames"] = np.array([digest(scene(number)) for number in sorted({cell.frame for cell in found})])
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)  # type: ignore[arg-type]  # keywords are arrays
    write_bytes(file, buffer.getvalue())
    write_bytes(file.with_suffix(".sha256"), f"{sha256_bytes(buffer.getvalue())}  {file.name}\n".encode())


@cache
def read(file: Path = FILE) -> dict[Cell, Scattered]:
    """The stored reference, by cell.

    Raises FoggyError if it is missing or altered, cells are missing, or the stand-in draws other frames than those
    that it was rendered of.
    """
    data = read_bytes(file, "reference", AGAIN)
    stated = read_bytes(file.with_suffix(".sha256"), "digest of the reference", AGAIN).decode().split()[0]
    if sha256_bytes(data) != stated:
        raise FoggyError(f"{file}: its sha256 is {sha256_bytes(data)[:12]}..., but {stated[:12]}... is stated. {AGAIN}")
    with np.load(io.BytesIO(data)) as stored:
        wanted = cells()
        missing = [cell.name for cell in wanted if cell.name not in stored]
        if missing:
            raise FoggyError(f"{file}: {len(missing)} cells missing, first {missing[0]}. {AGAIN}")
        for number, known in enumerate(stored["frames"]):
            if digest(scene(number)) != known:
                raise FoggyError(f"{file}: was rendered of another frame {number} than the stand-in draws now. {AGAIN}")
        errors = stored["errors"]
        return {
            cell: Scattered(stored[cell.name].astype(np.float64), float(error))
            for cell, error in zip(wanted, errors, strict=True)
        }


def digest(found: Scene) -> str:
    """SHA-256 of all that a frame's reference is made of."""
    geometry = repr((vars(found.camera), round(found.pitch, 6), round(found.height, 6), SIZE)).encode()
    return sha256_bytes(found.image.tobytes() + found.depth.tobytes() + found.labels.tobytes() + geometry)
