"""One file of depth in metres, for scripts and notebooks."""

from pathlib import Path

import numpy as np

from foggy_synscapes.depth.decoding import Encoding, decode
from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.depth_files import read_stored
from foggy_synscapes.io.files import read_bytes


def read(path: Path, scale: float | None = None) -> np.ndarray:
    """Depth, float32 or float64 (H, W), metres; see `foggy_synscapes.read_depth`.

    scale : metres per stored unit; None: the file holds metres as floating point

    Raises FoggyError if the file is missing, damaged or of another kind, or holds whole numbers without a scale.
    """
    stored = read_stored(read_bytes(path, "file of depth"), path)
    if scale is None and stored.dtype.kind == "f":
        return stored.astype(np.promote_types(stored.dtype, np.float32), copy=False)
    try:
        return decode(stored, Encoding(scale=scale))
    except ValueError as error:
        raise FoggyError(f"{path}: {error}".replace("--depth-scale", "read_depth(path, scale)")) from error
