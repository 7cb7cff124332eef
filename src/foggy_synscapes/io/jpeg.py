"""JPEG for pictures that are looked at and not computed with."""

import tempfile
from pathlib import Path

import numpy as np

from foggy_synscapes.errors import FoggyError

QUALITY = 88
"""Of 100: a street scene of 2048 x 1024 pixels takes about 240 kB, a tenth of its PNG."""


def encode_jpeg(pixels: np.ndarray) -> bytes:
    """Encode uint8 (H, W, 3) as JPEG; the same bytes for the same pixels. ValueError for another array.

    Raises FoggyError where the library refuses.
    """
    import OpenImageIO as oiio

    if pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[2] != 3 or pixels.size == 0:
        raise ValueError(f"pixels: {pixels.dtype} {pixels.shape}, expected uint8 (H, W, 3)")
    height, width = pixels.shape[:2]
    spec = oiio.ImageSpec(width, height, 3, "uint8")
    spec.attribute("Compression", f"jpeg:{QUALITY}")
    with tempfile.TemporaryDirectory() as folder:  # its encoder writes files only
        path = Path(folder) / "image.jpg"
        writer = oiio.ImageOutput.create(str(path))
        if not (writer and writer.open(str(path), spec) and writer.write_image(np.ascontiguousarray(pixels))):
            raise FoggyError(f"JPEG of {width} x {height} pixels: {oiio.geterror().strip() or 'cannot be written'}")
        writer.close()
        return path.read_bytes()
