"""Random resizing, cropping and flipping of an image with its label map."""

import numpy as np
import torch
import torch.nn.functional as functional

IGNORE = 255
FILL = (124, 116, 104)  # 8-bit RGB outside of the image: ImageNet's mean, which preprocessing turns into 0


def augment(
    image: np.ndarray,
    labels: np.ndarray,
    crop: tuple[int, int],
    scale: tuple[float, float],
    flip: bool,
    random: np.random.Generator,
    class_balance: bool = False,
) -> tuple[np.ndarray, np.ndarray]:
    """A random window of the image, brought to the size of the crop.

    Resizing by s and then cropping is cropping a window smaller by s and then resizing: only the window is touched.

    image : uint8 (H, W, 3); labels : uint8 (H, W), trainIds; crop : rows and columns of the result, in pixels
    scale : smallest and largest factor of the resizing, drawn uniformly; flip : mirror in half of the cases
    random : all random choices come from it, in a fixed number and order
    class_balance : centre the window on a pixel of a class that is drawn from the image's classes, each as likely as
        the next, and move it only as far as it must to stay inside; otherwise it lies anywhere. Source: RefineNet's
        released training code (crops of type "class_sample"), on which the SFSU fine-tuning is built

    Returns an image uint8 (*crop, 3), resized bilinearly, and labels uint8 (*crop), by nearest neighbour. Where the
    window is larger than the image, the rest is filled with `FILL` and ignored. Both may be views of what was given.
    """
    if image.shape[:2] != labels.shape:
        raise ValueError(f"labels: {labels.shape} pixels, but the image has {image.shape[:2]}")
    factor = random.uniform(*scale)
    corners = random.random(2)
    mirrored = random.random() < 0.5
    window = [max(1, round(side / factor)) for side in crop]
    centre = _balanced(labels, random) if class_balance else None
    rows, columns = (
        _span(size, part, place, pixel)
        for size, part, place, pixel in zip(labels.shape, window, corners, centre or (None, None), strict=True)
    )
    image, labels = _cut(image, rows, columns, FILL), _cut(labels, rows, columns, IGNORE)
    pixels = torch.from_numpy(image).permute(2, 0, 1)[None]
    if tuple(window) != tuple(crop):
        pixels = functional.interpolate(pixels, size=crop, mode="bilinear", align_corners=False)
        below, beside = (_nearest(out, part) for out, part in zip(crop, window, strict=True))
        labels = labels[below][:, beside]
    if flip and mirrored:
        pixels, labels = pixels.flip(3), labels[:, ::-1]
    return pixels[0].permute(1, 2, 0).numpy(), labels


def _nearest(out: int, part: int) -> np.ndarray:
    """Which of `part` pixels lies under the centre of each of `out` pixels along one axis."""
    return ((np.arange(out) + 0.5) * part / out).astype(np.intp)


def _balanced(labels: np.ndarray, random: np.random.Generator) -> tuple[int, int] | None:
    """Row and column of a pixel: of any class alike, and of its pixels any; None where nothing is labelled."""
    kind, place = random.random(2)
    counts = np.bincount(labels.ravel(), minlength=IGNORE + 1)[:IGNORE]
    classes = counts.nonzero()[0]
    if not len(classes):
        return None
    drawn = classes[int(kind * len(classes))]
    pixel = np.flatnonzero(labels == drawn)[int(place * counts[drawn])]
    return divmod(int(pixel), labels.shape[1])


def _span(size: int, part: int, place: float, pixel: int | None) -> tuple[int, int]:
    """Begin and end of a window along one axis: inside of the image, or around it where the window is larger.

    place : in [0, 1), of all that are possible; pixel : instead, what it is centred on as far as it can
    """
    low, high = sorted((0, size - part))
    begin = low + int(place * (high - low + 1)) if pixel is None else min(max(pixel - part // 2, low), high)
    return begin, begin + part


def _cut(array: np.ndarray, rows: tuple[int, int], columns: tuple[int, int], fill: int | tuple[int, ...]) -> np.ndarray:
    (top, bottom), (left, right) = rows, columns
    height, width = array.shape[:2]
    inside = array[max(top, 0) : min(bottom, height), max(left, 0) : min(right, width)]
    if inside.shape[:2] == (bottom - top, right - left):
        return inside
    # Row by row: a fill of three values, pixel by pixel, takes many times as long.
    row = np.empty((1, right - left, *array.shape[2:]), array.dtype)
    row[...] = fill
    whole = row.repeat(bottom - top, axis=0)
    whole[max(-top, 0) :, max(-left, 0) :][: inside.shape[0], : inside.shape[1]] = inside
    return whole
