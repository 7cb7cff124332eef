"""Loops over single pixels: consistency of two views, colour, the nearest pixel of a kind."""

import math

import numpy as np

from foggy_synscapes.jit import jit

THIRD = 1.0 / 3.0
LINEAR_BELOW = (6.0 / 29.0) ** 3  # CIE 15: below, the cube root is replaced by a line


@jit
def inconsistent(left, right, disparity, level, largest, out):
    """Mark pixels whose match in the right view lies outside of it, or differs by more than `largest` (squared).

    left, right : uint8 (H, W, 3); disparity : float64 (H, W), pixels; level : float64 (256,); out : bool (H, W)
    """
    height, width = disparity.shape
    for y in range(height):
        for x in range(width):
            place = x + 1 - disparity[y, x]
            rounded = math.floor(abs(place) + 0.5)  # halves away from zero
            match = rounded if place >= 0 else -rounded
            inside = 1 <= match <= width
            other = int(min(max(match, 1), width)) - 1
            error = 0.0
            for c in range(3):
                difference = level[left[y, x, c]] - level[right[y, other, c]]
                error += difference * difference
            out[y, x] = not (error <= largest and inside)


@jit
def lab(image, linear, matrix, out):
    """CIE L*a*b* of an image uint8 (H, W, 3), float64 (H, W, 3).

    linear : float64 (256,), light of each level; matrix : float64 (3, 3), from it to X, Y, Z relative to white
    """
    for y in range(image.shape[0]):
        for x in range(image.shape[1]):
            r, g, b = linear[image[y, x, 0]], linear[image[y, x, 1]], linear[image[y, x, 2]]
            fx = _root(matrix[0, 0] * r + matrix[0, 1] * g + matrix[0, 2] * b)
            fy = _root(matrix[1, 0] * r + matrix[1, 1] * g + matrix[1, 2] * b)
            fz = _root(matrix[2, 0] * r + matrix[2, 1] * g + matrix[2, 2] * b)
            out[y, x, 0] = 116.0 * fy - 16.0
            out[y, x, 1] = 500.0 * (fx - fy)
            out[y, x, 2] = 200.0 * (fy - fz)


@jit
def _root(value):
    return value**THIRD if value > LINEAR_BELOW else value * (841.0 / 108.0) + 4.0 / 29.0


@jit
def fill_nearest(values, hole):
    """Give each pixel of `hole` (bool) the value of the nearest other pixel, in place; of equally near ones the first,
    column by column."""
    height, width = values.shape
    above, below = np.full((height, width), -1, np.int32), np.full((height, width), -1, np.int32)
    for y in range(height):
        for x in range(width):
            above[y, x] = y if not hole[y, x] else above[y - 1, x] if y > 0 else -1
            z = height - 1 - y
            below[z, x] = z if not hole[z, x] else below[z + 1, x] if y > 0 else -1
    source = values.copy()
    for y in range(height):
        for x in range(width):
            if not hole[y, x]:
                continue
            nearest, found_row, found_column = np.int64(height) * height + np.int64(width) * width, -1, -1
            reach = 0
            while reach < width and reach * reach <= nearest:
                for column in (x - reach, x + reach):
                    if not 0 <= column < width:
                        continue
                    for row in (above[y, column], below[y, column]):
                        if row < 0:
                            continue
                        distance = (row - y) * (row - y) + reach * reach
                        first = column < found_column or (column == found_column and row < found_row)
                        if distance < nearest or (distance == nearest and first):
                            nearest, found_row, found_column = distance, row, column
                reach += 1
            values[y, x] = source[found_row, found_column]


@jit
def composite(image, transmittance, level, airlight, out):
    """Fog on an image uint8 (H, W, 3), to `out`; airlight : float64 (3,), as the 256 values of `level` are."""
    for y in range(image.shape[0]):
        for x in range(image.shape[1]):
            t = transmittance[y, x]
            for c in range(3):
                value = 255.0 * (t * level[image[y, x, c]] + (1.0 - t) * airlight[c])
                out[y, x, c] = np.uint8(math.floor(min(max(value, 0.0), 255.0) + 0.5))
