"""Between levels of 8 bits and linear radiance, as sRGB encodes it (IEC 61966-2-1)."""

import numpy as np

_LEVELS = np.arange(256) / 255.0
_LINEAR = np.where(_LEVELS <= 0.04045, _LEVELS / 12.92, ((_LEVELS + 0.055) / 1.055) ** 2.4)


def linear(levels: np.ndarray) -> np.ndarray:
    """Linear radiance from 0 to 1, float64, of levels, uint8 of any shape.

    >>> linear(np.array([0, 128, 255], np.uint8)).round(4)
    array([0.    , 0.2159, 1.    ])
    """
    return _LINEAR[levels]


def encoded(radiance: np.ndarray) -> np.ndarray:
    """Levels from 0 to 255, float64 and not rounded, of linear radiance, clipped to [0, 1].

    >>> encoded(np.array([0.0, 0.2158605, 1.0, 2.0])).round(3)
    array([  0., 128., 255., 255.])
    """
    clipped = np.clip(radiance, 0.0, 1.0)
    curve = 1.055 * np.maximum(clipped, 0.0031308) ** (1 / 2.4) - 0.055
    return 255.0 * np.where(clipped <= 0.0031308, 12.92 * clipped, curve)
