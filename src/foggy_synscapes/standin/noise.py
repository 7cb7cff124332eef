"""A tileable noise field that every texture looks into, and smooth fields made from few random values."""

import numpy as np

_SIDE = 256


def _octaves() -> np.ndarray:
    rng = np.random.default_rng(20190)
    field = np.zeros((_SIDE, _SIDE))
    for cells, weight in ((8, 0.9), (32, 0.7), (128, 0.6), (256, 0.5)):
        field += weight * upsample(rng.standard_normal((cells, cells)), (_SIDE, _SIDE), wrap=True)
    return (np.clip(field / (1.6 * field.std()), -1, 1)).astype(np.float32)


def upsample(coarse: np.ndarray, size: tuple[int, int], wrap: bool = False) -> np.ndarray:
    """Stretch an array (h, w) to `size` (rows, columns) with smooth (cubic step) blending between its values."""
    for axis, length in enumerate(size):
        cells = coarse.shape[axis]
        place = np.arange(length) / length * (cells if wrap else cells - 1)
        low = np.floor(place).astype(int)
        part = place - low
        part = part * part * (3 - 2 * part)
        part = part[:, None] if axis == 0 else part[None, :]
        coarse = coarse.take(low, axis) * (1 - part) + coarse.take((low + 1) % cells, axis) * part
    return coarse


NOISE = _octaves()
"""float32 (256, 256) in [-1, 1], tileable."""


def noise(u: np.ndarray, v: np.ndarray, scale: float = 1.0) -> np.ndarray:
    """Noise at surface coordinates, metres; `scale` in cells per metre."""
    rows = (u * np.float32(scale)).astype(np.int32) & (_SIDE - 1)
    columns = (v * np.float32(scale)).astype(np.int32) & (_SIDE - 1)
    return NOISE[rows, columns]
