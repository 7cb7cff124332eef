"""Loops that find the haziest pixels of an image, compiled by Numba: see `fog.airlight`.

A band is as many rows as a square of the dark channel is high: the squares around all of its pixels contain a part of
its middle row, which so tells what the dark channel there may be at most. In a street scene the haziest pixels are the
sky's: of 48 bands of the two real samples, 39 and 30 need no work beyond their middle row.
"""

import numpy as np

from foggy_synscapes.jit import jit

I = np.int32  # noqa: E741


@jit
def dark_channel(image, half, out):
    """Minimum over three channels and a square of 2 half + 1 pixels, half = 2^n - 1; uint8 (H, W, 3) to (H, W).

    Parts of the square outside the image do not count.
    """
    beside, known = np.empty(out.shape, np.uint8), np.zeros(out.shape[0], np.bool_)
    for first in range(0, out.shape[0], 2 * half + 1):
        _band(image, half, first, beside, known, out)


@jit
def haziest(image, half, rows, columns):
    """Pixels with the largest dark channel, as many as `rows`, `columns` have room for, at most H W.

    By dark channel descending, then column, then row. They are those of `dark_channel`'s whole result; only how many
    bands it takes to find them depends on the image.
    """
    height, width, side = image.shape[0], image.shape[1], 2 * half + 1
    beside, known = np.empty((height, width), np.uint8), np.zeros(height, np.bool_)
    dark = np.empty((height, width), np.uint8)
    most = np.empty((height + side - 1) // side, I)  # of the dark channel in each band: a bound, later the value
    exact = np.zeros(most.size, np.bool_)
    for band in range(most.size):
        middle = _middle(band * side, half, height)
        _beside(image, middle, half, beside, known)
        most[band] = _largest(beside[middle])
    alike = np.empty(height, np.int64)
    level, number = most.max(), 0
    while number < rows.size:
        count = 0
        for band in range(most.size):
            first = band * side
            if most[band] >= level and not exact[band]:
                most[band], exact[band] = _band(image, half, first, beside, known, dark), True
            if most[band] >= level:
                for y in range(first, min(first + side, height)):
                    alike[count] = y
                    count += 1
        number = _find(dark, alike[:count], np.uint8(level), number, rows, columns)
        level -= 1


@jit
def _band(image, half, first, beside, known, dark):
    """Dark channel of the band that begins at a row; returns its largest."""
    height, width = dark.shape
    last, middle = min(first + 2 * half + 1, height), _middle(first, half, height)
    for y in range(max(first - half, 0), min(last + half, height)):
        if not known[y]:
            _beside(image, y, half, beside, known)
    # A square's upper part ends with the middle row, and its lower one begins with it.
    line, largest = np.empty(width, np.uint8), np.uint8(0)
    _take(beside[middle], line)
    top = bottom = middle
    for y in range(last - 1, first - 1, -1):
        while top > max(y - half, 0):
            top -= 1
            _lower(line, beside[top])
        _take(line, dark[y])
    _take(beside[middle], line)
    for y in range(first, last):
        while bottom < min(y + half, height - 1):
            bottom += 1
            _lower(line, beside[bottom])
        _lower(dark[y], line)
        largest = max(largest, _largest(dark[y]))
    return largest


@jit
def _middle(first, half, height):
    """The row that the squares around all pixels of a band share; where the edge cuts it off, the last one."""
    return min(first + half, height - 1)


@jit
def _beside(image, y, half, beside, known):
    """Minimum over three channels and the `half` pixels on each side, of one row.

    Windows of 2, 4, ... 2^n values that begin at a pixel come from two of half the size. What is wanted is the window
    that begins at a pixel and the one that ends there; near the first edge, where `half` predecessors are missing,
    those that are there lie in the first window.
    """
    width = beside.shape[1]
    row, out = image[y].reshape(3 * width), beside[y]
    line, other = np.empty(width, np.uint8), np.empty(width, np.uint8)
    for x in range(width):
        line[x] = min(row[3 * x], min(row[3 * x + 1], row[3 * x + 2]))
    step = 1
    while step <= half:
        _lower_of(line[:-step], line[step:], other)
        _take(line[-step:], other[-step:])  # windows that the edge cuts off
        line, other = other, line
        step *= 2
    _lower_of(line[half:], line[:-half], out[half:])
    for x in range(min(half, width)):
        out[x] = min(line[x], line[0])
    known[y] = True


@jit
def _take(values, out):
    for x in range(values.size):  # an assignment to out[:] takes four times as long
        out[x] = values[x]


@jit
def _lower(values, others):
    """values = min(values, others), which must be other memory: only then whole vectors can be taken."""
    for x in range(values.size):
        values[x] = min(values[x], others[x])


@jit
def _lower_of(values, others, out):
    """out = min(values, others); `out` must be other memory than both."""
    for x in range(values.size):
        out[x] = min(values[x], others[x])


@jit
def _largest(values):
    largest = values[0]  # values.max() takes one after the other
    for x in range(values.size):
        largest = max(largest, values[x])
    return largest


@jit
def _find(values, among, level, number, rows, columns):
    """Append pixels of some rows that are equal to `level`, by column and then row, to the first `number` found."""
    found, few = np.zeros(values.shape[1], I), np.empty(values.shape[1], np.uint8)
    for top in range(0, among.size, 255):  # as many as 8 bits can count: a vector holds four times as many
        few[:] = np.uint8(0)
        for y in among[top : top + 255]:
            row = values[y]
            for x in range(row.size):
                few[x] += np.uint8(row[x] == level)
        for x in range(found.size):
            found[x] += few[x]
    for x in range(found.size):
        if found[x] > 0:
            for y in among:
                if values[y, x] == level:
                    rows[number], columns[number] = y, x
                    number += 1
                    if number == rows.size:
                        return number
    return number
