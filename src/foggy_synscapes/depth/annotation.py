"""The semantic reference of the bilateral filter: labels from the instance ids of Cityscapes."""

import numpy as np

OUT_OF_ROI = 3
"""Id of Cityscapes for what lies outside of the rectified image or is not annotated: it is no object."""


def labels(ids: np.ndarray) -> np.ndarray:
    """Labels from 0 without gaps, int32 (H, W), in the order of the ids; out of roi takes the nearest other id.

    ids : instance ids as Cityscapes stores them, uint16 (H, W)

    Raises ValueError if all pixels are out of roi.

    >>> labels(np.array([[3, 24000, 7, 7]], np.uint16)).tolist()
    [[1, 1, 0, 0]]
    """
    from foggy_synscapes.depth.kernels.pixels import fill_nearest

    if ids.dtype != np.uint16 or ids.ndim != 2:
        raise ValueError(f"instance ids: {ids.dtype} {ids.shape}, expected uint16 (H, W)")
    outside = ids == OUT_OF_ROI
    if outside.all():
        raise ValueError(f"instance ids: all pixels are {OUT_OF_ROI}, out of roi")
    found = ids.copy()
    fill_nearest(found, outside)
    there = np.bincount(found.reshape(-1), minlength=2**16) > 0
    return (np.cumsum(there) - 1).astype(np.int32)[found]
