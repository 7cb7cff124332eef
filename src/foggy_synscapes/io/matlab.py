"""Named arrays out of MATLAB files of version 7.3, which are HDF5."""

import io
from pathlib import Path
from typing import Any

import numpy as np

from foggy_synscapes.errors import UNFORESEEN, FoggyError
from foggy_synscapes.io.files import LARGEST_WEIGHTS, read_bytes


def read_parameters(path: str | Path) -> dict[str, np.ndarray]:
    """Parameters of the networks that a MATLAB file holds, however deep.

    MatConvNet keeps them in struct arrays with the fields `name` and `value`; layers of its simple networks have
    `filters` and `biases`. All others that the file holds (momenta, settings, pictures) are passed over.

    Returns
    -------
    Arrays by name, with MATLAB's order of axes.

    Raises
    ------
    FoggyError
        If the file cannot be read, is of another version, holds no parameter, or one of a name twice with other values.
    """
    try:
        import h5py
    except ImportError as error:
        raise FoggyError(
            f"{path}: MATLAB files need h5py. Install it by `pip install foggy-synscapes[matlab]`."
        ) from error
    found: dict[str, np.ndarray] = {}

    def keep(name: str, values: np.ndarray) -> None:
        if name in found and not np.array_equal(found[name], values):
            raise FoggyError(
                f"{path}: holds two different parameters named {name}. Is it a snapshot of several models?"
            )
        found[name] = values

    def visit(_place: str, item: Any) -> None:
        if not isinstance(item, h5py.Group):
            return
        if {"name", "value"} <= set(item):
            for name, value in zip(_cells(item["name"]), _cells(item["value"]), strict=True):
                if _is_text(name) and value.dtype.kind == "f" and value.ndim:
                    keep(_text(name), value[()].T)
        if {"filters", "biases"} <= set(item):
            for key in ("filters", "biases"):
                if item[key].dtype.kind == "f":
                    keep(key, item[key][()].T)

    try:
        with h5py.File(io.BytesIO(read_bytes(path, "MATLAB file", limit=LARGEST_WEIGHTS)), "r") as file:

            def _cells(data: Any) -> list[Any]:
                """The elements of a struct array's field; a struct that is alone has its field itself."""
                if data.dtype != h5py.ref_dtype:
                    return [data]
                return [file[reference] for reference in data[()].flatten()]

            file.visititems(visit)
    except (OSError, RuntimeError, MemoryError, *UNFORESEEN) as error:
        raise FoggyError(
            f"{path}: not a readable MATLAB file of version 7.3 ({error}). Older ones can be saved anew by MATLAB's "
            "save(..., '-v7.3')."
        ) from error
    if not found:
        raise FoggyError(f"{path}: holds no parameters of a MatConvNet network")
    return found


def _is_text(data: Any) -> bool:
    return data.attrs.get("MATLAB_class") == b"char"


def _text(data: Any) -> str:
    return "".join(chr(code) for code in data[()].flatten())
