"""The inner loops of fog, compiled by Numba: all betas of a frame in one pass, exact to the 8-bit level.

Samples are first computed in float32, many at a time, as v = 256.5 + F with F from 0 to 255. In that range a float32
counts in steps of 2^-15, here called units, so the lowest bits of v are, without any conversion, 15 bits of fraction
and 8 bits of level: floor(F + 0.5). The error of v against exact arithmetic is below 3 units (0.00009 of a level):
  - distance, beta and their product in float32: at most 5 roundings, relative 3.0e-7 of the exponent x, so
    255 x exp(-x) 3.0e-7 <= 2.8e-5 levels, 0.92 units;
  - exp: polynomial 2.6e-9, the last rounding of Horner's scheme 6.0e-8, the one before it and those of products and
    coefficients, scaled down by f <= 0.5, 5e-8 together: 255 * 1.1e-7 = 2.8e-5 levels, 0.92 units;
  - product with the difference of two colours and sum: 0.25 + 0.5 units.
Samples within 3 units of a step, about one in 5,000, are computed again in float64 with the published formula.
So the result never depends on the width of the processor's vectors, nor on whether it multiplies and adds in one
step, and equals that of plain float64 code.

What lies behind an optical depth of 6.25, such as the sky, is the airlight without any work: 255 exp(-6.25) = 0.492 is
less than half a level, whatever the clear image shows there.

Colours are apart, as planes, as long as they are computed with: mixed, they would have to be sorted for each vector.
"""

import math

import numpy as np

from foggy_synscapes.compiled import compiled, fused

# Constants of the width that keeps loops narrow.
F, U = np.float32, np.uint32
I = np.int32  # noqa: E741
LOG2E = math.log2(math.e)
HALF_UP = F(256.5)
# v is taken MARGIN units too high: a sample that may lie on the other side of a step then has a fraction below NEAR.
MARGIN, NEAR = F(3 * 2.0**-15), U(2 * 3)
SHIFT, FRACTION = U(15), U(2**15 - 1)
WHITE = F(255)
# Adding 1.5 * 2^23 rounds to an integer, which then stands in the lowest bits.
ROUNDER, EXPONENT = F(12582912.0), I(23)
# 2^-60 is 0 beside every other term; below 2^-126 the exponent bits would wrap around.
LOWEST = F(-60)
# 2^f on [-0.5, 0.5] as a polynomial through 7 Chebyshev nodes; relative error 2.6e-9.
C6, C5, C4 = F(0.00015461444676459477), F(0.001340042817725558), F(0.009618056678584931)
C3, C2, C1, C0 = F(0.055503272266708814), F(0.2402265092228826), F(0.6931472067028323), F(1.0)
HIDDEN = F(-6.25 * LOG2E)
SUB_FILTER = 1  # PNG specification, section 9.2: each byte minus that of the pixel on its left
GROUP = 64  # pixels that are hidden together or not
WORD, FOUR, ONE = np.uint64(8), np.uint64(4), np.uint64(1)  # unsigned: no index can be negative


@compiled
def _copy(values, out):
    for x in range(values.size):  # an assignment to out[:] takes four times as long
        out[x] = values[x]


@compiled
def _fill(value, out):
    for x in range(out.size):
        out[x] = value


@compiled
def _split(pixels, red, green, blue):
    for x in range(red.size):
        red[x] = pixels[3 * x]
        green[x] = pixels[3 * x + 1]
        blue[x] = pixels[3 * x + 2]


@compiled
def _mix(levels, out):
    """Planes of colour, uint8 (3, W), as pixels, uint8 (3 W,)."""
    red, green, blue = levels[0], levels[1], levels[2]
    for x in range(red.size):
        out[3 * x] = red[x]
        out[3 * x + 1] = green[x]
        out[3 * x + 2] = blue[x]


@compiled
def _mix_filtered(levels, out):
    """Planes of colour, uint8 (3, W), as a PNG's scan line with the filter Sub, uint8 (1 + 3 W,)."""
    red, green, blue, steps = levels[0, 1:], levels[1, 1:], levels[2, 1:], out[4:]
    left_red, left_green, left_blue = levels[0, :-1], levels[1, :-1], levels[2, :-1]
    out[0], out[1], out[2], out[3] = SUB_FILTER, levels[0, 0], levels[1, 0], levels[2, 0]
    for x in range(red.size):
        steps[3 * x] = red[x] - left_red[x]
        steps[3 * x + 1] = green[x] - left_green[x]
        steps[3 * x + 2] = blue[x] - left_blue[x]


@compiled
def _differences(levels, light, out):
    for x in range(levels.size):
        out[x] = F(levels[x]) - light


@compiled
def _distances(depth, row, columns, out):
    for x in range(out.size):
        out[x] = depth[x] * math.sqrt(row + columns[x])


@compiled
def _nearest(ranks, out):
    """Smallest distance of each group of pixels; `ranks`, `out`: as int32, in which floats from 0 keep their order."""
    for group in range(out.size):
        part = ranks[group * GROUP : (group + 1) * GROUP]
        nearest = part[0]
        for x in range(part.size):
            nearest = min(nearest, part[x])
        out[group] = nearest


@compiled
def _span(exponent, nearest, group):
    """Whether a group is hidden by fog, and the first group after it that is not alike."""
    hidden = exponent * nearest[group] <= HIDDEN
    end = group + 1
    while end < nearest.size and (exponent * nearest[end] <= HIDDEN) == hidden:
        end += 1
    return hidden, end


@fused
def _transmittances(distance, exponent, out):
    """exp2(exponent * distance); NaN (infinity times 0) gives 0."""
    for x in range(distance.size):
        e = exponent * distance[x]
        e = e if e >= LOWEST else LOWEST
        rounded = e + ROUNDER
        f = e - (rounded - ROUNDER)
        power = (((((C6 * f + C5) * f + C4) * f + C3) * f + C2) * f + C1) * f + C0
        # times 2^integer: the integer is added to the exponent's bits
        bits = np.float32(power).view(np.int32) + (np.float32(rounded).view(np.int32) << EXPONENT)
        out[x] = np.int32(bits).view(np.float32)


@fused
def _composite(t, reds, greens, blues, bases, red, green, blue, flags):
    """v = base + t difference for three channels; `red` ... get the levels, `flags` the pixels close to a step."""
    for x in range(t.size):
        r = np.float32(bases[0] + t[x] * reds[x]).view(np.uint32)
        g = np.float32(bases[1] + t[x] * greens[x]).view(np.uint32)
        b = np.float32(bases[2] + t[x] * blues[x]).view(np.uint32)
        red[x] = np.uint8(r >> SHIFT)
        green[x] = np.uint8(g >> SHIFT)
        blue[x] = np.uint8(b >> SHIFT)
        flags[x] = np.uint8(min(r & FRACTION, min(g & FRACTION, b & FRACTION)) < NEAR)


@fused
def _quantize(t, out, flags):
    base = HALF_UP + MARGIN
    for x in range(t.size):
        v = np.float32(base + t[x] * WHITE).view(np.uint32)
        out[x] = np.uint8(v >> SHIFT)
        flags[x] = np.uint8((v & FRACTION) < NEAR)


@compiled
def _flagged(flags, words, first, last, found):
    """Pixels from `first`, that of a group, to before `last` whose flag is set, into `found`; their number.

    flags : uint8, of whole groups, 0 behind the end of the row; words : the same as int64
    """
    count = 0
    for word in range(np.uint64(first) // WORD, (np.uint64(last) + WORD - ONE) // WORD, FOUR):
        # Four words at once: one pixel in 1,800 has a flag.
        if words[word] | words[word + ONE] | words[word + ONE + ONE] | words[word + FOUR - ONE]:
            for x in range(8 * np.int64(word), min(8 * np.int64(word + FOUR), last)):
                found[count] = x
                count += flags[x]
    return count


@compiled
def _exact(beta, depth, row, column, scale):
    return math.exp(-beta * (depth * math.sqrt((row + column) / scale)))


@compiled
def _level(radiance):
    return np.uint8(math.floor(255.0 * radiance + 0.5))


class _Scratch:
    """Memory for one row, and what all rows share; made outside the loops, which compile faster without it."""

    def __init__(self, rows: np.ndarray, columns: np.ndarray, scale: float, betas: np.ndarray) -> None:
        width = columns.size
        self.geometry = rows, columns, scale, (rows / scale).astype(F), (columns / scale).astype(F)
        # Finite, or a distance of 0 would give NaN; distances below 1e-36 m count as 0 then.
        self.fog = betas, np.maximum(-betas * LOG2E, -3e38).astype(F)
        groups = (width + GROUP - 1) // GROUP
        distance, nearest = np.empty(width, F), np.empty(groups, F)
        self.distance = distance, distance.view(I), nearest, nearest.view(I), np.empty(width, F)
        flags = np.zeros(groups * GROUP, np.uint8)
        self.flags = flags, flags.view(np.int64), np.empty(width + 1, np.int64)


def render(image, depth, rows, columns, scale, betas, airlight, out, filtered) -> None:
    """Fog on one image at each beta.

    image : uint8 (H, W, 3); depth : float32 (H, W), metres; distance = depth sqrt((rows[y] + columns[x]) / scale)
    betas : float64 (B,), 1/m, at least 0; airlight : uint8 (3,)
    out : uint8 (B, n), written: pixels, or where `filtered` scan lines of PNG with the filter Sub, 1 + 3 W each
    """
    height, width = depth.shape
    scratch = _Scratch(rows, columns, scale, betas)
    _render(
        image.reshape(height, 3 * width),  # flat rows: the compiler sees the step of 3, and takes whole vectors
        out,
        filtered,
        depth,
        *scratch.geometry,
        *scratch.fog,
        airlight,
        airlight.astype(F),
        *np.empty((2, 3, width), np.uint8),
        np.empty((3, width), F),
        *scratch.distance,
        *scratch.flags,
    )


@compiled
def _render(
    image, out, filtered, depth, rows, columns, scale, rows32, columns32, betas, exponents, airlight, light, clear,
    levels, differences, distance, ranks, nearest, ranked, t, flags, words, found,
):  # fmt: skip
    width = columns.size
    stride = 3 * width + filtered
    red, green, blue = levels[0], levels[1], levels[2]
    up = HALF_UP + MARGIN
    bases = light[0] + up, light[1] + up, light[2] + up
    for y in range(rows.size):
        _distances(depth[y], rows32[y], columns32, distance)
        _nearest(ranks, ranked)
        _split(image[y], clear[0], clear[1], clear[2])
        for c in range(3):
            _differences(clear[c], light[c], differences[c])
        for b in range(betas.size):
            group = 0
            if betas[b] == 0:  # no fog: also at infinite distance the image itself
                for c in range(3):
                    _copy(clear[c], levels[c])
                group = nearest.size
            while group < nearest.size:
                hidden, end = _span(exponents[b], nearest, group)
                first, last = group * GROUP, min(end * GROUP, width)
                part, group = slice(first, last), end
                if hidden:
                    _fill(airlight[0], red[part])
                    _fill(airlight[1], green[part])
                    _fill(airlight[2], blue[part])
                    continue
                _transmittances(distance[part], exponents[b], t[part])
                apart = differences[0, part], differences[1, part], differences[2, part]
                _composite(t[part], *apart, bases, red[part], green[part], blue[part], flags[part])
                for i in range(_flagged(flags, words, first, last, found)):
                    x = found[i]
                    share = _exact(betas[b], depth[y, x], rows[y], columns[x], scale)
                    for c in range(3):
                        hidden_part = (1.0 - share) * (airlight[c] / 255.0)
                        levels[c, x] = _level(share * (clear[c, x] / 255.0) + hidden_part)
            line = out[b, y * stride : (y + 1) * stride]
            if filtered:
                _mix_filtered(levels, line)
            else:
                _mix(levels, line)


def render_transmittance(depth, rows, columns, scale, betas, levels) -> None:
    """Transmittance at each beta as levels: uint8 (B, H, W), written; the rest as in `render`."""
    scratch = _Scratch(rows, columns, scale, betas)
    _render_transmittance(levels, depth, *scratch.geometry, *scratch.fog, *scratch.distance, *scratch.flags)


@compiled
def _render_transmittance(
    levels, depth, rows, columns, scale, rows32, columns32, betas, exponents,
    distance, ranks, nearest, ranked, t, flags, words, found,
):  # fmt: skip
    width = columns.size
    for y in range(rows.size):
        _distances(depth[y], rows32[y], columns32, distance)
        _nearest(ranks, ranked)
        for b in range(betas.size):
            out = levels[b, y]
            if betas[b] == 0:
                _fill(np.uint8(255), out)
                continue
            group = 0
            while group < nearest.size:
                hidden, end = _span(exponents[b], nearest, group)
                first, last = group * GROUP, min(end * GROUP, width)
                part, group = slice(first, last), end
                if hidden:
                    _fill(np.uint8(0), out[part])
                    continue
                _transmittances(distance[part], exponents[b], t[part])
                _quantize(t[part], out[part], flags[part])
                for i in range(_flagged(flags, words, first, last, found)):
                    x = found[i]
                    out[x] = _level(_exact(betas[b], depth[y, x], rows[y], columns[x], scale))


@compiled
def survey(depth):
    """Number of values that are negative or NaN, and of values that are 0."""
    wrong, zero = 0, 0
    for y in range(depth.shape[0]):
        row = depth[y]
        low, none = I(0), I(0)
        for x in range(row.size):
            low += I(0) if row[x] >= F(0) else I(1)
            none += I(1) if row[x] == F(0) else I(0)
        wrong += low
        zero += none
    return wrong, zero


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
            _copy(line, other)
            _lower(line[:-step], other[step:])
            step *= 2
        _copy(line, out[y])
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
def _lower(values, others):
    """values = min(values, others), which must be other memory: only then whole vectors can be taken."""
    for x in range(values.size):
        values[x] = min(values[x], others[x])


@compiled
def count(values, level):
    """How many values are equal to `level`, per column: int32 (W,)."""
    found, few = np.zeros(values.shape[1], I), np.empty(values.shape[1], np.uint8)
    for top in range(0, values.shape[0], 255):  # as many as 8 bits can count: a vector holds four times as many
        _fill(np.uint8(0), few)
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
