"""Loops over whole images that find the haziest pixels, compiled by Numba: see `fog.airlight`."""

import numpy as np

from foggy_synscapes.compiled import compiled

I = np.int32  # noqa: E741


@compiled
def dark_channel(image, half, out):
    """Minimum over three channels and a square of 2 half + 1 pixels, half = 2^n - 1; uint8 (H, W, 3) to (H, W).

    Windows of 2, 4, ... 2^n values that begin at a pixel come from two of half the size. The square around a pixel
    is the window that begins there and the one that ends there; near the first edge, where `half` predecessors
    are missing, those that are there lie in the first window. Parts outside the image do not count.
    """
    height, width = out.shape
    line, other = np.empty(width, np.uint8), np.empty(width, np.uint8)
    for y in range(height):
        row = image[y].reshape(3 * width)
        for x in range(width):
            line[x] = min(row[3 * x], min(row[3 * x + 1], row[3 * x + 2]))
        step = 1
        while step <= half:
            _take(line, other)
            _lower(line[:-step], other[step:])
            step *= 2
        _take(line, out[y])
        _lower(out[y, half:], line[:-half])
        for x in range(min(half, width)):
            out[y, x] = min(line[x], line[0])
    step = 1
    while step <= half:
        for y in range(height - step):
            _lower(out[y], out[y + step])
        step *= 2
    for y in range(height - 1, 0, -1):
        _lower(out[y], out[max(y - half, 0)])


@compiled
def _take(values, out):
    for x in range(values.size):  # an assignment to out[:] takes four times as long
        out[x] = values[x]


@compiled
def _lower(values, others):
    """values = min(values, others), which must be other memory: only then whole vectors can be taken."""
    for x in range(values.size):
        values[x] = min(values[x], others[x])


@compiled
def count(values, level):
    """How many values are equal to `level`, per column: int32 (W,)."""
    found, few = np.zeros(values.shape[1], I), np.empty(values.shape[1], np.uint8)
    for top in range(0, values.shape[0], 255):  # as many as 8 bits can count: a vector holds four times as many
        few[:] = np.uint8(0)
        for y in range(top, min(top + 255, values.shape[0])):
            row = values[y]
            for x in range(row.size):
                few[x] += np.uint8(row[x] == level)
        for x in range(found.size):
            found[x] += few[x]
    return found


@compiled
def find(values, level, per_column, rows, columns):
    """The first pixels that are equal to `level`, by column and then row, as many as `rows`, `columns` have room for.

    per_column : how many there are in each column, as `count` gives; at least as many in all as there is room for
    """
    number, column = 0, 0
    while number < rows.size:
        if per_column[column] > 0:
            for y in range(values.shape[0]):
                if number < rows.size and values[y, column] == level:
                    rows[number], columns[number] = y, column
                    number += 1
        column += 1
