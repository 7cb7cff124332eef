"""SLIC superpixels as its authors' C code makes them (Achanta et al., TPAMI 2012).

Rows and columns count from 0. Every sum is in the order of that code: its float64 results decide which of two centres
is nearer, so another order moves segment borders.
"""

import numpy as np

from foggy_synscapes.jit import jit

EPSILON, KAPPA = 0.008856, 903.3  # CIE 1931, rounded as in that code
THIRD = 1.0 / 3.0
ITERATIONS = 10
BESIDE = ((0, -1), (-1, 0), (0, 1), (1, 0))  # steps to the pixels on the left, above, on the right and below


@jit
def lab(image, linear, out):
    """Lab of an image uint8 (H, W, 3) as three planes, float64 (3, H, W).

    linear : float64 (256,), light of each level

    sRGB primaries and white D65 with the constants of the C code, which are not those of `depth.colour`.
    """
    for y in range(image.shape[0]):
        for x in range(image.shape[1]):
            r, g, b = linear[image[y, x, 0]], linear[image[y, x, 1]], linear[image[y, x, 2]]
            fx = _root((r * 0.4124564 + g * 0.3575761 + b * 0.1804375) / 0.950456)
            fy = _root(r * 0.2126729 + g * 0.7151522 + b * 0.0721750)
            fz = _root((r * 0.0193339 + g * 0.1191920 + b * 0.9503041) / 1.088754)
            out[0, y, x] = 116.0 * fy - 16.0
            out[1, y, x] = 500.0 * (fx - fy)
            out[2, y, x] = 200.0 * (fy - fz)


@jit
def _root(value):
    return value**THIRD if value > EPSILON else (KAPPA * value + 16.0) / 116.0


@jit
def cluster(planes, step, compactness, centres):
    """Label of the nearest centre of each pixel after ten rounds: int32 (H, W).

    planes : Lab, float64 (3, H, W); centres : float64 (5, N), Lab, column and row; moved in place
    """
    _, height, width = planes.shape
    labels, nearest = np.zeros((height, width), np.int32), np.empty((height, width))
    sums, counts = np.empty(centres.shape), np.empty(centres.shape[1])
    weight = 1.0 / ((step / compactness) * (step / compactness))
    for _ in range(ITERATIONS):
        nearest[:] = np.finfo(np.float64).max
        for k in range(centres.shape[1]):
            _claim(planes, centres[:, k], np.int32(k), step, weight, nearest, labels)
        sums[:], counts[:] = 0.0, 0.0
        for y in range(height):
            for x in range(width):
                k = labels[y, x]
                for c in range(3):
                    sums[c, k] += planes[c, y, x]
                sums[3, k] += x
                sums[4, k] += y
                counts[k] += 1.0
        for k in range(centres.shape[1]):
            share = 1.0 / max(counts[k], 1.0)
            for c in range(5):
                centres[c, k] = sums[c, k] * share
    return labels


@jit
def _claim(planes, centre, k, step, weight, nearest, labels):
    """Give centre k those pixels of its window to which it is nearer than every centre before it."""
    _, height, width = planes.shape
    left, right = max(int(centre[3] - step), 0), min(int(centre[3] + step), width)
    top, bottom = max(int(centre[4] - step), 0), min(int(centre[4] + step), height)
    for y in range(top, bottom):
        light, red, blue = planes[0, y, left:right], planes[1, y, left:right], planes[2, y, left:right]
        least, label = nearest[y, left:right], labels[y, left:right]
        down = y - centre[4]
        for i in range(light.size):
            dl, da, db = light[i] - centre[0], red[i] - centre[1], blue[i] - centre[2]
            dx = left + i - centre[3]
            distance = ((dl * dl + da * da) + db * db) + (dx * dx + down * down) * weight
            nearer = distance < least[i]
            least[i] = distance if nearer else least[i]
            label[i] = k if nearer else label[i]


@jit
def connect(labels, smallest, out):
    """Number 4-connected parts of equal label in the order of their first pixels; returns how many numbers there are.

    A part of at most `smallest` pixels takes the number of a neighbour, and its own is used again.
    out : int32 (H, W)
    """
    height, width = labels.shape
    out[:] = -1
    rows, columns = np.empty(labels.size, np.int32), np.empty(labels.size, np.int32)
    number, neighbour = 0, 0
    for top in range(height):
        for left in range(width):
            if out[top, left] >= 0:
                continue
            for down, across in BESIDE:
                y, x = top + down, left + across
                if 0 <= y < height and 0 <= x < width and out[y, x] >= 0:
                    neighbour = out[y, x]  # the last one counts; without any, that of the part before
            size = _flood(labels, top, left, number, rows, columns, out)
            if size <= smallest:
                for i in range(size):
                    out[rows[i], columns[i]] = neighbour
            else:
                number += 1
    return number


@jit
def _flood(labels, top, left, number, rows, columns, out):
    """Number one part, from its first pixel; its pixels go to `rows`, `columns`. Returns how many there are."""
    height, width = labels.shape
    label, size, done = labels[top, left], 1, 0
    rows[0], columns[0], out[top, left] = top, left, number
    while done < size:
        row, column = rows[done], columns[done]
        done += 1
        for down, across in BESIDE:
            y, x = row + down, column + across
            if 0 <= y < height and 0 <= x < width and out[y, x] < 0 and labels[y, x] == label:
                rows[size], columns[size], out[y, x] = y, x, number
                size += 1
    return size
