"""The inner loops of fog, compiled by Numba: all betas of a frame in one pass, exact to the 8-bit level.

Samples are first computed in float32, 16 or 8 at a time, as q = 65536 (255 F + 0.5). The result is the integer
part floor(q / 65536). Its error against exact arithmetic is below 8 units (0.00012 of a level):
  - distance, beta and their product in float32: at most 5 roundings, relative 3.0e-7 of the exponent x, so
    255 x exp(-x) 3.0e-7 <= 2.8e-5 levels;
  - exp: polynomial 2.6e-9 and 12 roundings in Horner's scheme, mostly scaled down by f <= 0.5: 255 * 1.2e-7 = 3.1e-5;
  - product, sum and conversion: 1.5e-5 + 0.8e-5 + 1.5e-5.
Samples within 8 units of a step, about one in 4,000, are computed again in float64 with the published formula.
So the result never depends on the width of the processor's vectors, and equals that of plain float64 code.

What lies behind an optical depth of 6.25, such as the sky, is the airlight without any work: 255 exp(-6.25) = 0.492 is
less than half a level, whatever the clear image shows there.
"""

import math

import numpy as np

from foggy_synscapes.compiled import compiled

F = np.float32
I = np.int32  # noqa: E741 (as F: constants of the width that keeps loops narrow)
LOG2E = math.log2(math.e)
UNIT, STEP, WHITE = F(65536), F(32768), F(255 * 65536)
SHIFT, FRACTION, NEAR, BOTH_SIDES = I(16), I(65535), I(8), I(16)
# Adding 1.5 * 2^23 rounds to an integer, which then stands in the lowest bits.
ROUNDER, EXPONENT = F(12582912.0), I(23)
# 2^-60 is 0 beside every other term; below 2^-126 the exponent bits would wrap around.
LOWEST = F(-60)
# 2^f on [-0.5, 0.5] as a polynomial through 7 Chebyshev nodes; relative error 2.6e-9.
C6, C5, C4 = F(0.00015461444676459477), F(0.001340042817725558), F(0.009618056678584931)
C3, C2, C1, C0 = F(0.055503272266708814), F(0.2402265092228826), F(0.6931472067028323), F(1.0)
HIDDEN = F(-6.25 * LOG2E)
GROUP, WORDS = 64, 8  # flags looked at together, and the same as 64-bit words


@compiled
def _copy(values, out):
    for x in range(values.size):  # an assignment to out[:] takes four times as long
        out[x] = values[x]


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


@compiled
def _transmittances(distance, exponent, rounded, integers, out, bits):
    """exp2(exponent * distance); NaN (infinity times 0) gives 0. `integers`, `bits`: `rounded`, `out` as int32."""
    for x in range(distance.size):
        e = exponent * distance[x]
        e = e if e >= LOWEST else LOWEST
        rounded[x] = e + ROUNDER
        f = e - (rounded[x] - ROUNDER)
        out[x] = (((((C6 * f + C5) * f + C4) * f + C3) * f + C2) * f + C1) * f + C0
    for x in range(distance.size):  # times 2^integer: the integer is added to the exponent's bits
        bits[x] += integers[x] << EXPONENT


@compiled
def _composite(t, red, green, blue, light, out, flags):
    """q = light + t difference for three channels; `out` gets the levels, `flags` the pixels close to a step."""
    for x in range(t.size):
        r = I(light[0] + t[x] * red[x])
        g = I(light[1] + t[x] * green[x])
        b = I(light[2] + t[x] * blue[x])
        out[3 * x] = np.uint8(r >> SHIFT)
        out[3 * x + 1] = np.uint8(g >> SHIFT)
        out[3 * x + 2] = np.uint8(b >> SHIFT)
        nearest = min((r + NEAR) & FRACTION, min((g + NEAR) & FRACTION, (b + NEAR) & FRACTION))
        flags[x] = np.uint8(nearest < BOTH_SIDES)


@compiled
def _quantize(t, out, flags):
    for x in range(t.size):
        q = I(t[x] * WHITE + STEP)
        out[x] = np.uint8(q >> SHIFT)
        flags[x] = np.uint8(((q + NEAR) & FRACTION) < BOTH_SIDES)


@compiled
def _any(words, start):
    together = np.int64(0)
    for i in range(start, start + WORDS):
        together |= words[i]
    return together != 0


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
        distance, rounded, t = np.empty((3, width), F)
        self.transmittance = distance, rounded, rounded.view(I), t, t.view(I)
        groups = (width + GROUP - 1) // GROUP
        flags = np.zeros(groups * GROUP, np.uint8)
        nearest = np.empty(groups, F)
        self.flags = flags, flags.view(np.int64), distance.view(I), nearest, nearest.view(I)


def render(image, depth, rows, columns, scale, betas, airlight, foggy) -> None:
    """Fog on one image at each beta.

    image : uint8 (H, W, 3); depth : float32 (H, W), metres; distance = depth sqrt((rows[y] + columns[x]) / scale)
    betas : float64 (B,), 1/m, at least 0; airlight : uint8 (3,); foggy : uint8 (B, H, W, 3), written
    """
    height, width = depth.shape
    scratch = _Scratch(rows, columns, scale, betas)
    light = UNIT * airlight.astype(F)
    differences = np.empty((3, width), F)
    # Flat rows: the compiler sees the step of 3, and takes whole vectors.
    flat = image.reshape(height, 3 * width), foggy.reshape(betas.size, height, 3 * width)
    _render(
        *flat,
        depth,
        *scratch.geometry,
        *scratch.fog,
        airlight,
        light,
        np.tile(airlight, width),
        differences,
        *scratch.transmittance,
        *scratch.flags,
    )


@compiled
def _render(
    image, foggy, depth, rows, columns, scale, rows32, columns32, betas, exponents, airlight, light, veil, differences,
    distance, rounded, integers, t, bits, flags, words, ranks, nearest, ranked,
):  # fmt: skip
    width = columns.size
    bases = light[0] + STEP, light[1] + STEP, light[2] + STEP
    red, green, blue = differences[0], differences[1], differences[2]
    for y in range(rows.size):
        clear = image[y]
        _distances(depth[y], rows32[y], columns32, distance)
        _nearest(ranks, ranked)
        for x in range(width):
            red[x] = UNIT * F(clear[3 * x]) - light[0]
            green[x] = UNIT * F(clear[3 * x + 1]) - light[1]
            blue[x] = UNIT * F(clear[3 * x + 2]) - light[2]
        for b in range(betas.size):
            out = foggy[b, y]
            if betas[b] == 0:  # no fog: also at infinite distance the image itself
                _copy(clear, out)
                continue
            group = 0
            while group < nearest.size:
                hidden, end = _span(exponents[b], nearest, group)
                first, last = group * GROUP, min(end * GROUP, width)
                if hidden:
                    _copy(veil[3 * first : 3 * last], out[3 * first : 3 * last])
                    group = end
                    continue
                part = slice(first, last)
                _transmittances(distance[part], exponents[b], rounded[part], integers[part], t[part], bits[part])
                _composite(t[part], red[part], green[part], blue[part], bases, out[3 * first : 3 * last], flags[part])
                while group < end:
                    if _any(words, group * WORDS):
                        for x in range(group * GROUP, min((group + 1) * GROUP, width)):
                            if flags[x]:
                                share = _exact(betas[b], depth[y, x], rows[y], columns[x], scale)
                                for c in range(3):
                                    hidden_part = (1.0 - share) * (airlight[c] / 255.0)
                                    out[3 * x + c] = _level(share * (clear[3 * x + c] / 255.0) + hidden_part)
                    group += 1


def render_transmittance(depth, rows, columns, scale, betas, levels) -> None:
    """Transmittance at each beta as levels: uint8 (B, H, W), written; the rest as in `render`."""
    scratch = _Scratch(rows, columns, scale, betas)
    _render_transmittance(levels, depth, *scratch.geometry, *scratch.fog, *scratch.transmittance, *scratch.flags)


@compiled
def _render_transmittance(
    levels, depth, rows, columns, scale, rows32, columns32, betas, exponents,
    distance, rounded, integers, t, bits, flags, words, ranks, nearest, ranked,
):  # fmt: skip
    width = columns.size
    for y in range(rows.size):
        _distances(depth[y], rows32[y], columns32, distance)
        _nearest(ranks, ranked)
        for b in range(betas.size):
            out = levels[b, y]
            if betas[b] == 0:
                for x in range(width):
                    out[x] = 255
                continue
            group = 0
            while group < nearest.size:
                hidden, end = _span(exponents[b], nearest, group)
                first, last = group * GROUP, min(end * GROUP, width)
                if hidden:
                    for x in range(first, last):
                        out[x] = 0
                    group = end
                    continue
                part = slice(first, last)
                _transmittances(distance[part], exponents[b], rounded[part], integers[part], t[part], bits[part])
                _quantize(t[part], out[part], flags[part])
                while group < end:
                    if _any(words, group * WORDS):
                        for x in range(group * GROUP, min((group + 1) * GROUP, width)):
                            if flags[x]:
                                out[x] = _level(_exact(betas[b], depth[y, x], rows[y], columns[x], scale))
                    group += 1


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
    found = np.zeros(values.shape[1], I)
    for y in range(values.shape[0]):
        row = values[y]
        for x in range(row.size):
            found[x] += I(1) if row[x] == level else I(0)
    return found
