"""The inner loops of fog, compiled by Numba: all betas of a frame in one pass, exact to the 8-bit level.

Samples are first computed in float32, 16 or 8 at a time, as q = 65536 (255 F + 0.5). The result is the integer
part floor(q / 65536). Its error against exact arithmetic is below 8 units (0.00012 of a level):
  - distance, beta and their product in float32: at most 5 roundings, relative 3.0e-7 of the exponent x, so
    255 x exp(-x) 3.0e-7 <= 2.8e-5 levels;
  - exp: polynomial 2.6e-9 and 12 roundings in Horner's scheme, mostly scaled down by f <= 0.5: 255 * 1.2e-7 = 3.1e-5;
  - product, sum and conversion: 1.5e-5 + 0.8e-5 + 1.5e-5.
Samples within 8 units of a step, about one in 4,000, are computed again in float64 with the published formula.
So the result never depends on the width of the processor's vectors, and equals that of plain float64 code.
"""

import math
from collections.abc import Callable

import numba
import numpy as np

F = np.float32
I = np.int32  # noqa: E741 (as F: constants of the width that keeps loops narrow)
LOG2E = math.log2(math.e)
UNIT = F(65536)
SHIFT, FRACTION, NEAR, BOTH_SIDES = I(16), I(65535), I(8), I(16)
HALF, BIAS, MANTISSA = F(0.5), I(127), I(23)
# 2^-60 is 0 beside every other term; below 2^-126 the exponent bits would wrap around.
LOWEST = F(-60)
# 2^f on [-0.5, 0.5] as a polynomial through 7 Chebyshev nodes; relative error 2.6e-9.
C6, C5, C4 = F(0.00015461444676459477), F(0.001340042817725558), F(0.009618056678584931)
C3, C2, C1, C0 = F(0.055503272266708814), F(0.2402265092228826), F(0.6931472067028323), F(1.0)
GROUP = 64  # flags looked at together


def compiled(function: Callable) -> Callable:
    """Compile at the first call and keep the machine code on disk where Numba finds a writable folder."""
    try:
        return numba.njit(cache=True)(function)
    except RuntimeError:  # neither the package's folder nor the user's cache can be written
        return numba.njit(function)


@compiled
def _distances(depth, row, columns, out):
    for x in range(out.size):
        out[x] = depth[x] * math.sqrt(row + columns[x])


@compiled
def _transmittances(distance, exponent, bits, scale, out):
    """exp2(exponent * distance); `scale` is `bits` seen as float32. NaN (infinity times 0) gives 0."""
    for x in range(distance.size):
        e = exponent * distance[x]
        e = e if e >= LOWEST else LOWEST
        k = I(e - HALF)
        f = e - F(k)
        bits[x] = (k + BIAS) << MANTISSA
        out[x] = (((((C6 * f + C5) * f + C4) * f + C3) * f + C2) * f + C1) * f + C0
    for x in range(distance.size):
        out[x] *= scale[x]


@compiled
def _spread(values, out):
    """Repeat each value for every channel; the usual numbers of channels as constants, which makes it fast."""
    if out.size == 3 * values.size:
        for x in range(values.size):
            out[3 * x] = values[x]
            out[3 * x + 1] = values[x]
            out[3 * x + 2] = values[x]
    else:
        for i in range(out.size):
            out[i] = values[i]


@compiled
def _composite(transmittance, difference, light, out, near):
    for i in range(out.size):
        q = I(light[i] + transmittance[i] * difference[i])
        out[i] = np.uint8(q >> SHIFT)
        near[i] = np.uint8(((q + NEAR) & FRACTION) < BOTH_SIDES)


@compiled
def _any(words):
    together = np.int64(0)
    for i in range(words.size):
        together |= words[i]
    return together != 0


@compiled
def _exact(depth, row, column, scale, beta, clear, light):
    t = math.exp(-beta * (depth * math.sqrt((row + column) / scale)))
    return np.uint8(math.floor(255.0 * (t * (clear / 255.0) + (1.0 - t) * (light / 255.0)) + 0.5))


@compiled
def render(image, depth, rows, columns, scale, betas, airlight, foggy):
    """Fog on one image at each beta.

    image : uint8 (H, W, C); depth : float (H, W), metres; distance = depth sqrt((rows[y] + columns[x]) / scale)
    betas : float64 (B,), 1/m, above 0; airlight : uint8 (C,); foggy : uint8 (B, H, W, C), written
    """
    height, width, channels = image.shape
    samples = channels * width
    distance, t = np.empty(width, F), np.empty(width, F)
    bits = np.empty(width, I)
    exponents_scale = bits.view(F)
    wide, difference = np.empty(samples, F), np.empty(samples, F)
    level, light = np.empty(samples, F), np.empty(samples, F)
    flags = np.zeros((samples + GROUP - 1) // GROUP * GROUP, np.uint8)
    near, words = flags[:samples], flags.view(np.int64)
    columns32 = (columns / scale).astype(F)
    for i in range(samples):
        level[i] = airlight[i % channels]
        light[i] = (airlight[i % channels] + 0.5) * 65536
    for y in range(height):
        clear = image[y].reshape(samples)
        _distances(depth[y], F(rows[y] / scale), columns32, distance)
        for i in range(samples):
            difference[i] = (F(clear[i]) - level[i]) * UNIT
        for b in range(betas.size):
            out = foggy[b, y].reshape(samples)
            _transmittances(distance, F(-betas[b] * LOG2E), bits, exponents_scale, t)
            _spread(t, wide)
            _composite(wide, difference, light, out, near)
            for g in range(0, words.size, 8):
                if _any(words[g : g + 8]):
                    for i in range(8 * g, min(8 * g + GROUP, samples)):
                        if near[i]:
                            x, c = i // channels, i % channels
                            out[i] = _exact(depth[y, x], rows[y], columns[x], scale, betas[b], clear[i], airlight[c])


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
    line = np.empty(width, np.uint8)
    for y in range(height):
        row = out[y]
        for x in range(width):
            row[x] = min(image[y, x, 0], min(image[y, x, 1], image[y, x, 2]))
        step = 1
        while step <= half:
            _lower(row[:-step], row[step:])
            step *= 2
        line[:] = row
        _lower(row[half:], line[:-half])
        for x in range(min(half, width)):
            row[x] = min(row[x], line[0])
    step = 1
    while step <= half:
        for y in range(height - step):
            _lower(out[y], out[y + step])
        step *= 2
    for y in range(height - 1, 0, -1):
        _lower(out[y], out[max(y - half, 0)])


@compiled
def _lower(values, others):
    """values = min(values, others), first to last: `others` may be the same memory further on."""
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
