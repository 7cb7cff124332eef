"""The dual-reference cross-bilateral filter on grids: one over position and colour, one over position and label.

Pixels are summed into cells (value and weight), cells are blurred by three along each axis, and read again by linear
interpolation, as Paris and Durand (2006) do. One row of cells at a time: four of them are all that a pixel row needs,
where the whole grid of a frame would take hundreds of megabytes.
"""

import math

import numpy as np

from foggy_synscapes.jit import jit

PAD = 3  # cells before the first and after the last
MIDDLE = 1.0 / (1.0 + 2.0 * math.exp(-0.5))  # of a Gaussian of one cell, cut off after one
SIDE = math.exp(-0.5) * MIDDLE


@jit
def apply(colour, lowest, counts, labels, kinds, source, spacing, range_, share, out):
    """The filtered source: float64 (H, W).

    colour : float64 (H, W, 3), lowest : its minima; counts : cells along each colour axis
    labels : int32 (H, W), 0 to kinds - 1; source : float64 (H, W)
    spacing : pixels per cell; range_ : colour per cell; share : weight of the reference colour, that of labels is 1
    """
    height, width = source.shape
    across = (width - 1) // spacing + 1 + 2 * PAD
    cells = np.zeros((4, across, counts[0], counts[1], counts[2], 2))
    marks = np.zeros((4, across, kinds, 2))
    for row in range(-1, 1):  # row r of cells, without its padding, lies in place r % 4
        _splat(colour, lowest, labels, source, spacing, range_, row, cells[row % 4], marks[row % 4])
    smooth, smooth_marks = np.zeros((2, *cells.shape[1:])), np.zeros((2, *marks.shape[1:]))
    last = (height - 1) // spacing
    for row in range(last + 1):
        for ahead in range(row + 1, row + 3) if row == 0 else range(row + 2, row + 3):
            _splat(colour, lowest, labels, source, spacing, range_, ahead, cells[ahead % 4], marks[ahead % 4])
        for i in range(2):
            here = row + i
            _between(cells[(here - 1) % 4], cells[here % 4], cells[(here + 1) % 4], smooth[i])
            _between(marks[(here - 1) % 4], marks[here % 4], marks[(here + 1) % 4], smooth_marks[i])
        for y in range(row * spacing, min(row * spacing + spacing, height)):
            _slice(
                colour[y], lowest, labels[y], y / spacing - row, spacing, range_, share, smooth, smooth_marks, out[y]
            )


@jit
def _rounded(value):
    return math.floor(value + 0.5)  # of what is not negative: halves away from zero


@jit
def _splat(colour, lowest, labels, source, spacing, range_, row, cells, marks):
    """Sum the pixels nearest to a row of cells into it, and blur it along all axes but its own."""
    cells[:], marks[:] = 0.0, 0.0
    height, width = source.shape
    for y in range(max((row - 1) * spacing, 0), min((row + 1) * spacing + 1, height)):
        if _rounded(y / spacing) != row:
            continue
        for x in range(width):
            place = _rounded(x / spacing) + PAD
            i, j, k = (
                _rounded((colour[y, x, 0] - lowest[0]) / range_) + PAD,
                _rounded((colour[y, x, 1] - lowest[1]) / range_) + PAD,
                _rounded((colour[y, x, 2] - lowest[2]) / range_) + PAD,
            )
            cells[place, i, j, k, 0] += source[y, x]
            cells[place, i, j, k, 1] += 1.0
            marks[place, labels[y, x], 0] += source[y, x]
            marks[place, labels[y, x], 1] += 1.0
    size = cells.shape[1] * cells.shape[2] * cells.shape[3] * 2
    _blur(cells.reshape(1, cells.shape[0], size))
    _blur(cells.reshape(cells.shape[0], cells.shape[1], size // cells.shape[1]))
    _blur(cells.reshape(cells.shape[0] * cells.shape[1], cells.shape[2], cells.shape[3] * 2))
    _blur(cells.reshape(cells.shape[0] * cells.shape[1] * cells.shape[2], cells.shape[3], 2))
    _blur(marks.reshape(1, marks.shape[0], marks.shape[1] * 2))


@jit
def _blur(values):
    """Along the middle axis, in place; nothing comes from outside."""
    before, line = np.empty(values.shape[2]), np.empty(values.shape[2])
    for i in range(values.shape[0]):
        before[:] = 0.0
        for j in range(values.shape[1] - 1):
            here, after = values[i, j], values[i, j + 1]
            for k in range(here.size):
                line[k] = here[k]
                here[k] = SIDE * before[k] + MIDDLE * line[k] + SIDE * after[k]
            before, line = line, before
        here = values[i, values.shape[1] - 1]
        for k in range(here.size):
            here[k] = SIDE * before[k] + MIDDLE * here[k]


@jit
def _between(above, here, below, out):
    above, here, below, out = above.reshape(-1), here.reshape(-1), below.reshape(-1), out.reshape(-1)
    for i in range(out.size):
        out[i] = SIDE * above[i] + MIDDLE * here[i] + SIDE * below[i]


@jit
def _slice(colour, lowest, labels, down, spacing, range_, share, cells, marks, out):
    """Read a row of pixels from the two rows of cells between which it lies, `down` from 0 to 1 below the first."""
    for x in range(out.size):
        place = x / spacing
        column = int(place)
        u = place - column
        column += PAD
        p, q, r = (
            (colour[x, 0] - lowest[0]) / range_,
            (colour[x, 1] - lowest[1]) / range_,
            (colour[x, 2] - lowest[2]) / range_,
        )
        i, j, k = int(p), int(q), int(r)
        p, q, r = p - i, q - j, r - k
        i, j, k = i + PAD, j + PAD, k + PAD
        value = weight = marked = marked_weight = 0.0
        for a in range(2):
            part = down if a else 1 - down
            for b in range(2):
                corner = part * (u if b else 1 - u)
                mark = marks[a, column + b, labels[x]]
                marked += corner * mark[0]
                marked_weight += corner * mark[1]
                for c in range(2):
                    one = corner * (p if c else 1 - p)
                    for d in range(2):
                        two = one * (q if d else 1 - q)
                        near = cells[a, column + b, i + c, j + d]
                        value += two * ((1 - r) * near[k, 0] + r * near[k + 1, 0])
                        weight += two * ((1 - r) * near[k, 1] + r * near[k + 1, 1])
        total = marked_weight + share * weight
        out[x] = (marked + share * value) / total if total > 0 else 0.0
