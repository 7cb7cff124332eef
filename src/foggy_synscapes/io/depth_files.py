"""Files that hold a map of depth, disparity or transmittance, by their ending: values as they are stored.

A new format is one function and one line of FORMATS.
"""

import io
import tokenize
import zipfile
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from foggy_synscapes.errors import UNFORESEEN, FoggyError
from foggy_synscapes.io.files import named
from foggy_synscapes.io.images import (
    AGAIN,
    GREY,
    KINDS,
    LARGEST,
    RGB,
    RGBA,
    png_header,
    read_exr_channel,
    read_grey16,
    read_ids,
    read_other,
    read_rgb,
    read_rgba,
)  # fmt: skip

HDF5 = b"\x89HDF\r\n\x1a\n"
TYPES = ("uint16", "int16", "uint32", "int32", "half", "float", "double")  # of TIFF; 8 bits hold no depth


@dataclass(frozen=True)
class Format:
    """A format of files.

    text : for help and messages
    read : (content, path, name of a channel or array, or empty) -> numbers (H, W), or uint8 (H, W, 3);
        FoggyError if the file is damaged or holds no such map
    """

    text: str
    read: Callable[[bytes, Path, str], np.ndarray]


def read_stored(data: bytes, path: Path, channel: str = "") -> np.ndarray:
    """Values of a file as they are stored: numbers (H, W), or uint8 (H, W, 3) of an 8-bit RGB PNG.

    data : content of the file at `path`; channel : of an EXR, or name of an array in a file of several

    Raises FoggyError if the file is damaged, larger than 100 megapixels, of an unknown ending, or holds no such map.
    """
    found = FORMATS.get(path.suffix.lower())
    if found is None:
        raise FoggyError(f"{path}: ends in {path.suffix or 'nothing'}; read are {known()}")
    return found.read(data, path, channel)


def known() -> str:
    """The formats that are read, for messages."""
    return ", ".join(f"{ending} ({entry.text})" for ending, entry in FORMATS.items())


def _exr(data: bytes, path: Path, channel: str) -> np.ndarray:
    return read_exr_channel(data, str(path), channel)


def _png(data: bytes, path: Path, channel: str) -> np.ndarray:
    _no_channel(path, channel)
    header = png_header(data, str(path))
    if header.bits == 8 and header.kind == RGB:
        return read_rgb(data, str(path))
    if header.bits == 8 and header.kind == RGBA:
        return np.ascontiguousarray(read_rgba(data, str(path))[..., :3])
    if header.kind != GREY or header.bits < 16:
        raise FoggyError(
            f"{path}: {header}, expected 16-bit {KINDS[GREY]}. An 8-bit copy has lost its precision; is this a preview?"
        )
    return read_grey16(data, str(path))


def read_map(data: bytes, path: Path, channel: str = "") -> np.ndarray:
    """The same as `read_stored`, but 8-bit grey PNG too: maps of transmittance are published in 8 bits."""
    if path.suffix.lower() == ".png" and png_header(data, str(path)).bits == 8:
        return read_ids(data, str(path))
    return read_stored(data, path, channel)


def _npy(data: bytes, path: Path, channel: str) -> np.ndarray:
    _no_channel(path, channel)
    return _array(data, path)


def _npz(data: bytes, path: Path, channel: str) -> np.ndarray:
    try:
        with named(path, ".npz file", AGAIN), zipfile.ZipFile(io.BytesIO(data)) as found:
            names = [entry.filename for entry in found.infolist() if entry.filename.endswith(".npy")]
            member = _one(path, {name.removesuffix(".npy"): name for name in names}, channel)
            if found.getinfo(member).file_size > 8 * LARGEST + 4096:
                raise FoggyError(f"{path}: array {member} is larger than {LARGEST // 10**6} million pixels")
            return _array(found.read(member), path)
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError) as error:
        raise FoggyError(f"{path}: not a readable .npz file: {error}. {AGAIN}") from error


def _array(data: bytes, path: Path) -> np.ndarray:
    stream = io.BytesIO(data)
    with named(path, "NumPy array", AGAIN):
        version = np.lib.format.read_magic(stream)
        read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        try:
            shape, _, kind = read(stream)
        except (SyntaxError, tokenize.TokenError) as error:  # a header is read as Python's own text
            raise ValueError(f"its header cannot be read: {error}") from error
        # A header may claim anything: memory is taken for what is there only.
        if kind.hasobject or stream.tell() + int(np.prod(shape, dtype=object)) * kind.itemsize != len(data):
            raise ValueError(f"its header claims {kind} {shape}, but it has {len(data):,} bytes")
        stream.seek(0)
        return _flat(np.load(stream, allow_pickle=False), path)


def _tiff(data: bytes, path: Path, channel: str) -> np.ndarray:
    _no_channel(path, channel)
    return read_other(data, path, str(path), (1,), TYPES)[..., 0]


def _mat(data: bytes, path: Path, channel: str) -> np.ndarray:
    return _flat(_mat_arrays_7_3(data, path, channel) if data[512:520] == HDF5 or data[:8] == HDF5
                 else _mat_arrays(data, path, channel), path)  # fmt: skip


def _mat_arrays(data: bytes, path: Path, channel: str) -> np.ndarray:
    try:
        from scipy.io import loadmat
    except ImportError as error:
        raise FoggyError(f"{path}: MATLAB files need SciPy: pip install foggy-synscapes[matlab]") from error
    try:
        # SciPy's reader raises errors of many kinds for damaged files, NotImplementedError among them.
        found = loadmat(io.BytesIO(data), variable_names=[channel] if channel else None)
    except (OSError, zlib.error, MemoryError, NotImplementedError, EOFError, AssertionError, *UNFORESEEN) as error:
        raise FoggyError(f"{path}: not a readable MATLAB file: {error}. {AGAIN}") from error
    return _one(path, {name: value for name, value in found.items() if _is_map(name, value)}, channel)


def _mat_arrays_7_3(data: bytes, path: Path, channel: str) -> np.ndarray:
    try:
        import h5py
    except ImportError as error:
        raise FoggyError(
            f"{path}: MATLAB files of version 7.3 need h5py: pip install foggy-synscapes[matlab]"
        ) from error
    try:
        with h5py.File(io.BytesIO(data), "r") as file:
            maps = {
                name: item for name, item in file.items()
                if isinstance(item, h5py.Dataset) and item.dtype.kind in "fiu" and item.ndim == 2
                and item.size <= LARGEST
            }  # fmt: skip
            return _one(path, maps, channel)[()].T  # MATLAB counts down the columns
    except (OSError, RuntimeError, MemoryError, *UNFORESEEN) as error:
        raise FoggyError(f"{path}: not a readable MATLAB file of version 7.3 ({error}). {AGAIN}") from error


def _is_map(name: str, value: Any) -> bool:
    return not name.startswith("__") and isinstance(value, np.ndarray) and value.ndim == 2 and value.dtype.kind in "fiu"


def _one(path: Path, arrays: dict[str, Any], channel: str) -> Any:
    """The array of a name, or the only one."""
    if channel and channel not in arrays:
        raise FoggyError(f"{path}: no array {channel}; there are {', '.join(arrays) or 'none'}")
    if not channel and len(arrays) != 1:
        raise FoggyError(f"{path}: {len(arrays)} arrays ({', '.join(arrays) or 'none'}). Name one by --depth-channel.")
    return arrays[channel] if channel else next(iter(arrays.values()))


def _flat(values: np.ndarray, path: Path) -> np.ndarray:
    """(H, W) of (H, W), (1, H, W) or (H, W, 1), as networks write them."""
    if values.ndim == 3 and 1 in (values.shape[0], values.shape[2]):
        values = values[0] if values.shape[0] == 1 else values[..., 0]
    if values.ndim != 2 or not 0 < values.size <= LARGEST or values.dtype.kind not in "fiu":
        raise FoggyError(f"{path}: {values.dtype} {values.shape}, expected one number for each pixel, (rows, columns)")
    return values.astype(values.dtype.newbyteorder("="))


def _no_channel(path: Path, channel: str) -> None:
    if channel:
        raise FoggyError(f"{path}: --depth-channel {channel}: a {path.suffix} file has one map, without a name")


FORMATS = {
    ".exr": Format("a channel of floating point, Z if it is not named", _exr),
    ".png": Format("16 bits", _png),
    ".npy": Format("NumPy", _npy),
    ".npz": Format("NumPy", _npz),
    ".tif": Format("16 bits or floating point", _tiff),
    ".tiff": Format("the same", _tiff),
    ".mat": Format("MATLAB", _mat),
}
"""By ending, in the order in which a folder is searched."""
