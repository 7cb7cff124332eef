"""Ground truth in the forms that the datasets annotate it: instance ids, and coarse polygons."""

import numpy as np

from foggy_synscapes.standin.traffic import STRIDE


def instance_colours(instances: np.ndarray) -> np.ndarray:
    """Instance numbers uint32 (H, W) as uint8 (H, W, 3): number = R + 256 G + 65536 B.

    >>> instance_colours(np.array([[240001]], dtype=np.uint32)).tolist()
    [[[129, 169, 3]]]
    """
    return np.stack([(instances >> shift) & 255 for shift in (0, 8, 16)], axis=-1).astype(np.uint8)


def instance_ids(label_ids: np.ndarray, instances: np.ndarray) -> np.ndarray:
    """Cityscapes' instanceIds, uint16 (H, W): labelId * 1000 + n on road users, the labelId elsewhere."""
    numbered = instances // STRIDE * 1000 + instances % STRIDE
    return np.where(instances > 0, numbered, label_ids).astype(np.uint16)


def coarsen(label_ids: np.ndarray) -> np.ndarray:
    """Coarse labels, uint8 (H, W): blobs well inside each region, unlabelled (0) borders and small things.

    The border is about one pixel in a hundred of the image's width.
    """
    radius = max(2, label_ids.shape[1] // 128)
    low, high = _window(label_ids, radius, np.minimum), _window(label_ids, radius, np.maximum)
    core = np.where(low == high, label_ids, 0).astype(np.uint8)
    # Grown back part of the way, where only one label is near: edges get the straightness of polygons.
    grown = radius - 1
    highest = _window(core, grown, np.maximum)
    lowest = _window(np.where(core == 0, 255, core).astype(np.uint8), grown, np.minimum)
    return np.where(highest == lowest, highest, 0).astype(np.uint8)


def _window(values: np.ndarray, radius: int, choose: np.ufunc) -> np.ndarray:
    for axis in (0, 1):
        pad = [(radius, radius) if k == axis else (0, 0) for k in (0, 1)]
        padded = np.pad(values, pad, mode="edge")
        length = values.shape[axis]
        result = padded.take(range(length), axis)
        for shift in range(1, 2 * radius + 1):
            result = choose(result, padded.take(range(shift, shift + length), axis))
        values = result
    return values
