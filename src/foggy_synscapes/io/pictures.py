"""Pictures of any camera: what may stand for an RGB image is taken as one; and images written as JPEG."""

import tempfile
from pathlib import Path

import numpy as np

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.files import named
from foggy_synscapes.io.images import GREY, RGBA, SIGNATURE, png_header, read_ids, read_other, read_rgb, read_rgba

QUALITY = 95
"""Of JPEG, 1 to 100: the coarsest at which fog shows no blocks in a sky."""


def read_picture(data: bytes, path: Path) -> np.ndarray:
    """An 8-bit image as uint8 (H, W, 3): RGB, RGB with an alpha channel that hides nothing, or grey, three times.

    data : content of the file at `path`, in any format of OpenImageIO

    Raises FoggyError if the file is damaged, larger than 100 megapixels, of more than 8 bits, or partly transparent.
    """
    name = str(path)
    if data[:8] != SIGNATURE:
        return _opaque(read_other(data, path, name, (1, 3, 4)), name)
    header = png_header(data, name)
    if header.bits == 8 and header.kind == RGBA:
        return _opaque(read_rgba(data, name), name)
    if header.bits == 8 and header.kind == GREY:
        return _opaque(read_ids(data, name)[..., None], name)
    return read_rgb(data, name)


def _opaque(pixels: np.ndarray, name: str) -> np.ndarray:
    if pixels.shape[2] == 4:
        hidden = int(np.count_nonzero(pixels[..., 3] != 255))
        if hidden:
            raise FoggyError(f"{name}: {hidden} pixels are transparent. Flatten it to RGB: what lies behind them?")
    if pixels.shape[2] == 1:
        return np.repeat(pixels, 3, axis=2)
    return np.ascontiguousarray(pixels[..., :3])


def encode_jpeg(pixels: np.ndarray, quality: int = QUALITY) -> bytes:
    """Encode uint8 (H, W, 3) as JPEG with full colour resolution; the same bytes for the same pixels.

    Raises ValueError if the array has another shape or type, or no pixel.
    """
    import OpenImageIO as oiio

    if pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[2] != 3 or pixels.size == 0:
        raise ValueError(f"pixels: {pixels.dtype} {pixels.shape}, expected uint8 (H, W, 3)")
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], 3, "uint8")
    spec.attribute("Compression", f"jpeg:{quality}")
    spec.attribute("jpeg:subsampling", "4:4:4")
    with tempfile.TemporaryDirectory() as folder:  # its encoder writes to files only
        path = Path(folder) / "image.jpg"
        writer = oiio.ImageOutput.create(str(path))
        if not (writer and writer.open(str(path), spec) and writer.write_image(np.ascontiguousarray(pixels))):
            raise FoggyError(f"{path}: cannot be encoded as JPEG: {writer.geterror() if writer else oiio.geterror()}")
        writer.close()
        with named(path, "JPEG"):
            return path.read_bytes()
