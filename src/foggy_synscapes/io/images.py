"""Reading and writing images: strict about what a file holds, near the speed of its codec.

Who does what, and why it is not one library (CPU ms per 1440 x 720 image, one thread):
PNG is inflated by ISA-L, every checksum verified, and unfiltered by libspng (12 for a foggy image; libspng alone, which
verifies no checksum, 24); it is encoded by the Up filter and ISA-L's deflate (11; OpenImageIO at its fastest 45).
EXR depth is read and written by OpenEXR (17; OpenImageIO 30). OpenImageIO reads colour images that are no PNG.
"""

import io
import os
import struct
import sys
import threading
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from isal import igzip_lib, isal_zlib

from foggy_synscapes.errors import FoggyError
from foggy_synscapes.io.files import named, read_bytes

SIGNATURE = b"\x89PNG\r\n\x1a\n"
JPEG, START_OF_SCAN, END_OF_IMAGE = b"\xff\xd8\xff", b"\xff\xda", b"\xff\xd9"  # ITU-T T.81, table B.1
GREY, RGB, RGBA = 0, 2, 6
KINDS = {0: "grey", 2: "RGB", 3: "palette", 4: "grey with alpha", 6: "RGB with alpha"}
KNOWN = (b"IHDR", b"PLTE", b"IDAT", b"IEND")  # chunks that a reader of PNG has to know
SAMPLES = {GREY: 1, RGB: 3, RGBA: 4}  # of a pixel
# First row and column, and steps, of the passes of an interlaced image (PNG specification, section 8.2).
ADAM7 = (0, 0, 8, 8), (0, 4, 8, 8), (4, 0, 8, 4), (0, 2, 4, 4), (2, 0, 4, 2), (0, 1, 2, 2), (1, 0, 2, 1)
LARGEST = 100_000_000  # pixels; a header that claims more is an attack or an accident
MOST_CHANNELS = 8  # of an EXR at the largest size; of a smaller one more
LOSSLESS = ("NO", "RLE", "ZIPS", "ZIP", "PIZ", "HTJ2K32", "HTJ2K256", "ZSTD")  # compressions of EXR
AGAIN = "Fetch or make the file again."
_thread = threading.local()
UP_FILTER = 2  # PNG specification, section 9.2: each byte minus the byte above it


@dataclass(frozen=True)
class PngHeader:
    """What the first chunk of a PNG says: width and height in pixels, bits per sample, colour type."""

    width: int
    height: int
    bits: int
    kind: int

    def __str__(self) -> str:
        return f"{self.bits}-bit {KINDS.get(self.kind, f'colour type {self.kind}')}"


def read_rgb(source: Path | str | bytes, name: str | None = None) -> np.ndarray:
    """Read an 8-bit RGB image, PNG or (from a path) any format of OpenImageIO: uint8 (H, W, 3).

    `source` is a path, or the bytes of a PNG that errors call `name`.

    Raises
    ------
    FoggyError
        If the file is missing, damaged, larger than 100 megapixels, or anything but 8-bit RGB.
    """
    data, name = _bytes(source, name)
    if data[:8] != SIGNATURE and not isinstance(source, bytes):
        return read_other(data, Path(source), name)
    return _read_png(data, name, 8, RGB, "Convert it to 8-bit RGB without alpha.")


def read_ids(source: Path | str | bytes, name: str | None = None) -> np.ndarray:
    """Read an 8-bit grey PNG of class ids: uint8 (H, W). Raises FoggyError as `read_rgb` does."""
    hint = "Is this the colour preview? Ids are stored as grey values, without a palette."
    return _read_png(*_bytes(source, name), 8, GREY, hint)


def read_grey16(source: Path | str | bytes, name: str | None = None) -> np.ndarray:
    """Read a 16-bit grey PNG, such as a disparity map: uint16 (H, W). Raises FoggyError as `read_rgb` does."""
    return _read_png(*_bytes(source, name), 16, GREY, "An 8-bit copy has lost its precision.")


def read_rgba(source: Path | str | bytes, name: str | None = None) -> np.ndarray:
    """Read an 8-bit RGB PNG with alpha: uint8 (H, W, 4). Raises FoggyError as `read_rgb` does."""
    return _read_png(*_bytes(source, name), 8, RGBA, "Convert it.")


def read_depth(source: Path | str | bytes, name: str | None = None) -> np.ndarray:
    """Read channel Z of an EXR file: float32 (H, W), planar depth in metres, values as they are stored.

    Raises
    ------
    FoggyError
        If the file is missing, damaged, larger than 100 megapixels, of several parts, compressed with loss, or holds
        anything but one channel named Z of 32-bit floats.
    """
    data, name = _bytes(source, name)
    depth = _read_exr(data, name, header_only=False)
    if depth.dtype != np.float32:
        raise FoggyError(f"{name}: channel Z is {depth.dtype}, expected float32: rounded depth changes pixels")
    return depth


def read_exr_channel(source: Path | str | bytes, name: str | None = None, channel: str = "") -> np.ndarray:
    """Read one channel of floating point of an EXR file: float32 or float16 (H, W), values as they are stored.

    channel : its name; where it is empty, the only one, or Z

    Raises FoggyError as `read_depth` does, and if there is no such channel of floating point.
    """
    data, name = _bytes(source, name)
    values = _read_exr(data, name, header_only=False, channel=channel)
    if values.dtype.kind != "f":
        raise FoggyError(f"{name}: channel {channel or 'Z'} is {values.dtype}, expected floating point")
    return values


def read_depth_header(source: Path | str | bytes, name: str | None = None) -> dict[str, Any]:
    """Attributes of an EXR file with one channel Z by name, as the OpenEXR library gives them; its pixels are not read.

    Raises FoggyError as `read_depth` does.
    """
    return _read_exr(*_bytes(source, name), header_only=True)


def encode_png(pixels: np.ndarray, level: int = 1) -> bytes:
    """Encode uint8 (H, W), uint8 (H, W, 3) or uint16 (H, W) as PNG; the same bytes for the same pixels.

    `level` is ISA-L's deflate effort, 0 (fastest) to 3.

    Raises
    ------
    ValueError
        If the array has another shape or type, no pixel, or `level` is outside 0 to 3.
    """
    kinds = {(2, "uint8"): (8, GREY), (3, "uint8"): (8, RGB), (2, "uint16"): (16, GREY)}
    kind = kinds.get((pixels.ndim, pixels.dtype.name))
    if kind is None or pixels.size == 0 or (pixels.ndim == 3 and pixels.shape[2] != 3):
        expected = "uint8 (H, W), uint8 (H, W, 3) or uint16 (H, W)"
        raise ValueError(f"pixels: {pixels.dtype} {pixels.shape}, expected {expected}")
    if level not in range(4):
        raise ValueError(f"level: {level}, expected 0 to 3")
    height, width = pixels.shape[:2]
    if pixels.dtype == np.uint16:
        pixels = pixels.astype(">u2").view(np.uint8)  # PNG stores the high byte first
    rows = np.ascontiguousarray(pixels).reshape(height, -1)
    filtered = scratch(height, 1 + rows.shape[1])
    filtered[:, 0] = UP_FILTER
    filtered[0, 1:] = rows[0]
    np.subtract(rows[1:], rows[:-1], out=filtered[1:, 1:])
    return assemble_png(width, height, *kind, isal_zlib.compress(filtered, level))


def assemble_png(width: int, height: int, bits: int, kind: int, data: bytes, interlaced: int = 0) -> bytes:
    """A PNG file around the deflated rows of an image."""
    header = struct.pack(">IIBBBBB", width, height, bits, kind, 0, 0, interlaced)
    chunks = (b"IHDR", header), (b"IDAT", data), (b"IEND", b"")
    return SIGNATURE + b"".join(part for kind, data in chunks for part in _chunk(kind, data))


def scratch(height: int, width: int) -> np.ndarray:
    """Memory of the last image of this size in this thread: fresh pages would cost a tenth of the encoding."""
    kept = getattr(_thread, "scratch", None)
    if kept is None or kept.shape != (height, width):
        kept = _thread.scratch = np.empty((height, width), np.uint8)
    return kept


def encode_depth(depth: np.ndarray) -> bytes:
    """Encode float32 (H, W), planar metres, as an EXR with one channel Z and ZIPS compression, without a time.

    Raises ValueError if the array has another shape or type, or no pixel.
    """
    import OpenEXR

    if depth.ndim != 2 or depth.dtype != np.float32 or depth.size == 0:
        raise ValueError(f"depth: {depth.dtype} {depth.shape}, expected float32 (H, W)")
    header = {"compression": OpenEXR.ZIPS_COMPRESSION, "type": OpenEXR.scanlineimage}
    buffer = io.BytesIO()
    OpenEXR.File(header, {"Z": np.ascontiguousarray(depth)}, num_threads=0).write(buffer)
    return buffer.getvalue()


def png_header(data: bytes, name: str) -> PngHeader:
    """Size and kind of a PNG from its first 33 bytes; FoggyError that calls it `name` if it is none."""
    if data[:8] != SIGNATURE or data[12:16] != b"IHDR" or len(data) < 33:
        raise FoggyError(f"{name}: not a PNG file ({len(data)} bytes). {AGAIN}")
    width, height, bits, kind, *methods, interlaced = struct.unpack(">IIBBBBB", data[16:29])
    _check_size(width, height, name)
    if any(methods) or interlaced > 1:
        raise FoggyError(f"{name}: compressed by a method that PNG does not have. {AGAIN}")
    return PngHeader(width, height, bits, kind)


def is_whole_png(path: Path | str) -> bool:
    """Whether a file is a PNG with all its chunks undamaged; the pixels are not decoded."""
    try:
        _inflated(*_bytes(path, None))
    except FoggyError:
        return False
    return True


def _bytes(source: Path | str | bytes, name: str | None) -> tuple[bytes, str]:
    if isinstance(source, bytes):
        return source, name or "image"
    return read_bytes(source, "image"), name or str(source)


def _inflated(data: bytes, name: str) -> bytes:
    """Scan lines of a PNG, of which all checksums were verified: of each the number of its filter and its bytes."""
    header = png_header(data, name)
    view, at, kind, packed = memoryview(data), 8, b"", []
    while kind != b"IEND":
        size = int.from_bytes(data[at : at + 4], "big")
        kind, end = data[at + 4 : at + 8], at + 8 + size
        if end + 4 > len(data):
            raise FoggyError(f"{name}: cut off at {len(data)} bytes. {AGAIN}")
        if isal_zlib.crc32(view[at + 4 : end]) != int.from_bytes(data[end : end + 4], "big"):
            raise FoggyError(f"{name}: damaged (checksum of a chunk at byte {at}). {AGAIN}")
        if kind == b"IDAT":
            packed.append(view[at + 8 : end])
        elif kind[:1].isupper() and kind not in KNOWN:
            raise FoggyError(f"{name}: holds {kind!r}, which no reader of PNG may pass over. {AGAIN}")
        at = end + 4
    bits, length = header.bits * SAMPLES.get(header.kind, 4), 0
    for top, left, down, right in ADAM7 if data[28] else ((0, 0, 1, 1),):
        rows, columns = len(range(top, header.height, down)), len(range(left, header.width, right))
        length += rows * (1 + (columns * bits + 7) // 8) if columns else 0
    stream = isal_zlib.decompressobj()
    try:
        lines = stream.decompress(packed[0] if len(packed) == 1 else b"".join(packed), length + 1)
    except igzip_lib.IsalError as error:  # type: ignore[misc]  # its types call the exception a value
        raise FoggyError(f"{name}: cannot be decoded: {error}. {AGAIN}") from error
    if len(lines) != length or not stream.eof:
        raise FoggyError(f"{name}: cannot be decoded: its rows end too early or too late. {AGAIN}")
    return lines


def _read_png(data: bytes, name: str, bits: int, kind: int, hint: str) -> np.ndarray:
    import pyspng

    header = png_header(data, name)
    if (header.bits, header.kind) != (bits, kind):
        raise FoggyError(f"{name}: {header}, expected {bits}-bit {KINDS[kind]}. {hint}")
    lines = _inflated(data, name)
    if len(lines) > len(data) * 9 // 8:  # libspng inflates slower than ISA-L did just now: it gets the rows as they are
        data = assemble_png(header.width, header.height, bits, kind, zlib.compress(lines, 0), data[28])
    try:
        if bits == 16:  # libspng adds an alpha channel to 16-bit grey
            return np.ascontiguousarray(pyspng.load(data)[..., 0])
        return pyspng.load(data, {GREY: "L", RGB: "RGB", RGBA: "RGBA"}[kind])
    except RuntimeError as error:
        raise FoggyError(f"{name}: cannot be decoded: {error}. {AGAIN}") from error


def read_other(
    data: bytes, path: Path, name: str, channels: tuple[int, ...] = (3,), types: tuple[str, ...] = ("uint8",)
) -> np.ndarray:
    """Read a file in any format of OpenImageIO, values as they are stored: (H, W, C).

    data : of the file at `path`; channels, types : numbers of channels and types of samples that may be

    Raises FoggyError, calling it `name`, if it is damaged, larger than 100 megapixels, or of another kind.
    """
    import OpenImageIO as oiio

    # Its decoder of JPEG fills what is missing with grey. Within a scan, FF is never followed by D9.
    if data[:3] == JPEG and data.rfind(END_OF_IMAGE) < data.rfind(START_OF_SCAN):
        raise FoggyError(f"{name}: cut off at {len(data)} bytes. {AGAIN}")
    reader = oiio.ImageInput.open(str(path))
    if not reader:
        raise FoggyError(f"{name}: not a readable image: {oiio.geterror().strip()}. {AGAIN}")
    try:
        spec = reader.spec()
        _check_size(spec.width, spec.height, name)
        # Colours of printing inks come out as three channels, in colours of no stated kind.
        kind = "CMYK" if spec.get_string_attribute("jpeg:ColorSpace") == "CMYK" else f"{spec.nchannels} channels"
        if kind not in (f"{number} channels" for number in channels) or str(spec.format) not in types:
            expected = f"{' or '.join(map(str, channels))} channel{'s' * (channels != (1,))} of {' or '.join(types)}"
            raise FoggyError(f"{name}: {kind} of {spec.format}, expected {expected}. Convert it.")
        pixels, problem = reader.read_image(str(spec.format)), reader.geterror()
        if pixels is None or problem:  # where a part is missing, it is grey
            raise FoggyError(f"{name}: cannot be decoded: {problem}. {AGAIN}")
        return pixels
    finally:
        reader.close()


def _check_size(width: int, height: int, name: str) -> None:
    if not (width > 0 and height > 0 and width * height <= LARGEST):
        raise FoggyError(f"{name}: claims {width} x {height} pixels, expected 1 to {LARGEST // 10**6} million")


def _read_exr(data: bytes, name: str, header_only: bool, channel: str | None = None) -> Any:
    """Header or a channel of an EXR file; the header is checked first. No channel at all: Z has to be the only one."""
    import OpenEXR

    try:
        with _silence(), named(name, "EXR file", AGAIN):
            file = OpenEXR.File(io.BytesIO(data), header_only=True, num_threads=0)
            header = file.header()
            channel = _checked_channel(header, len(file.parts), channel, name)
            if header_only:
                return header
            apart = len(header["channels"]) > 1
            whole = OpenEXR.File(io.BytesIO(data), separate_channels=apart, num_threads=0)
            return whole.channels()[channel].pixels
    except RuntimeError as error:  # what its library raises by itself
        raise FoggyError(f"{name}: not a readable EXR file: {error}. {AGAIN}") from error


def _checked_channel(header: dict, parts: int, wanted: str | None, name: str) -> str:
    """The channel to read; FoggyError if there is none, or the file is not plain and without loss."""
    channels = {channel.name: channel for channel in header["channels"]}
    compression, storage = header["compression"].name.removesuffix("_COMPRESSION"), header["type"].name
    if parts != 1 or storage not in ("scanlineimage", "tiledimage"):
        raise FoggyError(f"{name}: {parts} parts of the kind {storage}, expected one plain image")
    found = f"{len(channels)} channels" if len(channels) > 3 else f"channel {', '.join(channels) or 'none'}"
    if wanted is None and [*channels] != ["Z"]:
        raise FoggyError(f"{name}: {found}, expected 1 named Z. Is this the colour preview?")
    chosen = wanted or (next(iter(channels)) if len(channels) == 1 else "Z")
    if chosen not in channels:
        listed = ", ".join([*channels][:12])
        raise FoggyError(f"{name}: no channel {chosen}; name the one of depth by --depth-channel, out of {listed}")
    if compression not in LOSSLESS:
        raise FoggyError(f"{name}: compressed by {compression}, which rounds depth. Write it anew by ZIP.")
    if (channels[chosen].xSampling, channels[chosen].ySampling) != (1, 1):
        raise FoggyError(f"{name}: channel {chosen} has not all pixels of its image, expected a sampling of 1")
    (left, top), (right, bottom) = (corner.tolist() for corner in header["dataWindow"])
    _check_size(right - left + 1, (bottom - top + 1) * max(1, len(channels) // MOST_CHANNELS), name)
    if not all(map(np.array_equal, header["dataWindow"], header["displayWindow"])):
        raise FoggyError(f"{name}: a part of its image only (data window {left}, {top} to {right}, {bottom})")
    return chosen


def _chunk(kind: bytes, data: bytes) -> tuple[bytes, ...]:
    checksum = isal_zlib.crc32(data, isal_zlib.crc32(kind))
    return struct.pack(">I", len(data)), kind, data, struct.pack(">I", checksum)


@contextmanager
def _silence() -> Iterator[None]:
    """Keep the EXR library's own complaints off the terminal: the error raised here says it once."""
    sys.stderr.flush()
    kept = os.dup(2)
    try:
        with open(os.devnull, "w") as nowhere, redirect_stdout(nowhere):
            os.dup2(nowhere.fileno(), 2)
            yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
