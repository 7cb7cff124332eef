"""Label maps of random classes, how tests write them, and how they are scored."""

import json
from pathlib import Path

import numpy as np

from foggy_synscapes.cli import main
from foggy_synscapes.io.atomic import write_bytes
from foggy_synscapes.io.images import encode_png


def random_ids(seed: int, shape: tuple[int, int] = (12, 20), void: bool = True) -> np.ndarray:
    """trainIds of all classes, with some ignored pixels."""
    rng = np.random.default_rng(seed)
    ids = rng.integers(0, 19, shape).astype(np.uint8)
    if void:
        ids[0] = 255
    return ids


def put(path: Path, ids: np.ndarray) -> None:
    write_bytes(path, encode_png(ids))


def score(folder: Path, *options: str) -> tuple[int, dict | None]:
    out = folder / "metrics.json"
    out.unlink(missing_ok=True)
    paths = ["--predictions", str(folder / "predictions"), "--labels", str(folder / "labels"), "--out", str(out)]
    status = main(["evaluate", *paths, *options])
    return status, json.loads(out.read_text()) if out.exists() else None
