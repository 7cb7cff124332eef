"""The inner loops of fog, compiled by Numba: all betas of a frame in one pass, exact to the 8-bit level.

Samples are first computed in float32, many at a time, as v = 256.5 + F with F from 0 to 255. In that range a float32
counts in steps of 2^-15, here called units, so the lowest bits of v are, without any conversion, 15 bits of fraction
and 8 bits of level: floor(F + 0.5). Where a beta is twice the one before it, its transmittance is the square of that
one's. The error of v against exact arithmetic, where t is the product of n values of exp(-x / n):
  - distance, beta and their product in float32: at most 5 roundings, relative 3.0e-7 of the exponent x, so
    relative 3.0e-7 x of t;
  - exp: polynomial 2.6e-9, the last rounding of Horner's scheme 6.0e-8, the one before it and those of products and
    coefficients, scaled down by f <= 0.5, 5e-8 together: relative 1.13e-7, n times;
  - squares: 6.0e-8 for each of n - 1 products;
  - all this times 255 t = 255 exp(-x), at the worst x: 1.4 units for n = 1, 2.4 for n = 2, 5.3 for n = 4;
  - product with the difference of two colours and sum: 0.25 + 0.5 units.
Samples within 3, 4 and 7 units of a step, about one in 4,000, are computed again in float64 with the published
formula, and so are all samples at betas that float32 could not hold with their distances. So the result never depends
on the width of the processor's vectors, nor on whether it multiplies and adds in one step, and equals that of plain
float64 code.

What lies behind an optical depth of 6.25, such as the sky, is the airlight without any work: 255 exp(-6.25) = 0.492 is
less than half a level, whatever the clear image shows there.

Colours are apart, as planes, as long as they are computed with: mixed, they would have to be sorted for each vector.
"""

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from foggy_synscapes.jit import jit, jit_contracted

# Constants of the width that keeps loops narrow.
F, U = np.float32, np.uint32
I = np.int32  # noqa: E741
LOG2E = math.log2(math.e)
# Adding 1.5 * 2^23 rounds to an integer, which then stands in the lowest bits.
ROUNDER, EXPONENT = F(12582912.0), I(23)
# 2^-30 is 0 beside every other term; fourth powers of smaller numbers would lose bits.
LOWEST = F(-30)
# 2^f on [-0.5, 0.5] as a polynomial through 7 Chebyshev nodes; relative error 2.6e-9.
C6, C5, C4 = F(0.00015461444676459477), F(0.001340042817725558), F(0.009618056678584931)
C3, C2, C1, C0 = F(0.055503272266708814), F(0.2402265092228826), F(0.6931472067028323), F(1.0)
HIDDEN = F(-6.25 * LOG2E)
SUB_FILTER = 1  # PNG specification, section 9.2: each byte minus that of the pixel on its left
GROUP = 64  # pixels that are hidden together or not: a whole number of blocks

# Some loops are written in vectors, as code of LLVM and of no processor in particular. A compiler would find vectors
# too, but narrow the levels of each channel by itself, which takes half of the time of compositing; here four vectors
# of words are laid over each other before their bytes are brought into order.
BLOCK = 32  # pixels that are composited together: four vectors of eight

BYTE, HALF, WORD, ADDRESS = ir.IntType(8), ir.IntType(16), ir.IntType(32), ir.IntType(64)
FLOATS, WORDS = ir.VectorType(ir.FloatType(), 8), ir.VectorType(WORD, 8)
HALVES, BYTES = ir.VectorType(HALF, 16), ir.VectorType(BYTE, 32)
# Four vectors, interleaved as bytes 0, 2, 1, 3 of each word, one after the other.
IN_ORDER = ir.Constant(ir.VectorType(WORD, 32), [4 * lane + place for place in (0, 2, 1, 3) for lane in range(8)])
# The bytes of one channel in two lots of four pixels, three zeros behind each: its values as words.
APART = [
    ir.Constant(
        ir.VectorType(WORD, 32),
        [byte for first in (channel, channel + 20) for pixel in range(4) for byte in (first + 3 * pixel, 32, 32, 32)],
    )
    for channel in range(3)
]
ALL = ir.Constant(ir.VectorType(WORD, 64), list(range(64)))
# Three vectors one after the other, the colours of each pixel together.
MIXED = ir.Constant(ir.VectorType(WORD, 96), [32 * channel + pixel for pixel in range(32) for channel in range(3)])


@jit
def _split(pixels, y, planes):
    """A row of pixels, uint8 (H, 3 W), as planes of colour, uint8 (3, W)."""
    for x in range(pixels.shape[1] // 3):
        planes[0, x] = pixels[y, 3 * x]
        planes[1, x] = pixels[y, 3 * x + 1]
        planes[2, x] = pixels[y, 3 * x + 2]


@jit
def _mix(planes, out):
    """Planes of colour, uint8 (3, W), as pixels, uint8 (3 W,)."""
    for x in range(out.size // 3):
        out[3 * x] = planes[0, x]
        out[3 * x + 1] = planes[1, x]
        out[3 * x + 2] = planes[2, x]


@jit
def _fill(colour, first, last, planes):
    for c in range(3):
        for x in range(first, last):
            planes[c, x] = colour[c]


@jit
def _distances(depth, y, row, columns, out):
    for x in range(columns.size):
        out[x] = depth[y, x] * math.sqrt(row + columns[x])


@jit
def _nearest(ranks, out):
    """Smallest distance of each group of pixels; `ranks`, `out`: as int32, in which floats from 0 keep their order."""
    for group in range(out.size):
        part = ranks[group * GROUP : (group + 1) * GROUP]
        nearest = part[0]
        for x in range(part.size):
            nearest = min(nearest, part[x])
        out[group] = nearest


@jit
def _span(exponent, nearest, group):
    """Whether a group is hidden by fog, and the first group after it that is not alike."""
    hidden = exponent * nearest[group] <= HIDDEN
    end = group + 1
    while end < nearest.size and (exponent * nearest[end] <= HIDDEN) == hidden:
        end += 1
    return hidden, end


@jit_contracted
def transmittances(distance, exponent, first, last, t):
    """exp2(exponent * distance); NaN (infinity times 0) gives 0."""
    for x in range(first, last):
        e = exponent * distance[x]
        e = e if e >= LOWEST else LOWEST
        rounded = e + ROUNDER
        f = e - (rounded - ROUNDER)
        power = (((((C6 * f + C5) * f + C4) * f + C3) * f + C2) * f + C1) * f + C0
        # times 2^integer: the integer is added to the exponent's bits
        bits = np.float32(power).view(np.int32) + (np.float32(rounded).view(np.int32) << EXPONENT)
        t[x] = np.int32(bits).view(np.float32)


@jit
def square(t, first, last):
    for x in range(first, last):
        t[x] = t[x] * t[x]


@intrinsic
def _difference_vectors(typing, pixels, light, out, wide) -> tuple[types.Type, Callable]:
    """Eight pixels minus the airlight, as planes of colour.

    pixels : address of their 24 bytes; light : three float32
    out : address of the first one in float32 (3, wide), written
    """

    def build(context: Any, builder: ir.IRBuilder, signature: Any, arguments: list[ir.Value]) -> ir.Value:
        pixels, light, out, wide = arguments
        # Twice 16 bytes, from 0 and from 8 on: four pixels each, so that no byte has to change its half of a register.
        halves = [
            builder.load(builder.inttoptr(place, ir.VectorType(BYTE, 16).as_pointer()), align=1)
            for place in (pixels, builder.add(pixels, ir.Constant(ADDRESS, 8)))
        ]
        both = builder.shuffle_vector(*halves, ir.Constant(ir.VectorType(WORD, 32), list(range(32))))
        for channel in range(3):
            words = builder.shuffle_vector(both, _all(BYTES, 0), APART[channel])
            values = builder.uitofp(builder.bitcast(words, WORDS), FLOATS)
            values = builder.fsub(values, _spread(builder, builder.extract_value(light, channel), FLOATS))
            place = _moved(builder, out, builder.mul(wide, ir.Constant(ADDRESS, 4)), channel)
            builder.store(values, builder.inttoptr(place, FLOATS.as_pointer()), align=4)
        return context.get_dummy_value()

    return types.void(pixels, light, out, wide), build


@intrinsic
def _subtract_block(typing, planes, wide, out) -> tuple[types.Type, Callable]:
    """Mix one block of pixels, each minus the one before it.

    planes : address of the pixel before the first one in uint8 (3, wide); out : address of the first one's red, written
    """

    def build(context: Any, builder: ir.IRBuilder, signature: Any, arguments: list[ir.Value]) -> ir.Value:
        planes, wide, out = arguments
        colours = []
        for channel in range(3):
            before = _moved(builder, planes, wide, channel)
            left, right = (
                builder.load(builder.inttoptr(place, BYTES.as_pointer()), align=1)
                for place in (before, builder.add(before, ir.Constant(ADDRESS, 1)))
            )
            colours.append(builder.sub(right, left))
        both = builder.shuffle_vector(colours[0], colours[1], ALL)
        blue = builder.shuffle_vector(colours[2], colours[2], ALL)
        mixed = builder.shuffle_vector(both, blue, MIXED)
        builder.store(mixed, builder.inttoptr(out, mixed.type.as_pointer()), align=1)
        return context.get_dummy_value()

    return types.void(planes, wide, out), build


@intrinsic
def _composite_block(typing, t, differences, levels, wide, bases, near) -> tuple[types.Type, Callable]:
    """Composite one block: whether one of its samples lies near a step.

    t, differences, levels : addresses of the block's first pixel in arrays float32 (wide,), float32 (3, wide) and
        uint8 (3, wide), the last written; the sample is v = bases[c] + t difference, its level bits 15 to 22 of v
    bases : three float32 from 256 up, such that v stays below 512; near : uint32, a step is near where bits 0 to 14
        of v are less
    """

    def build(context: Any, builder: ir.IRBuilder, signature: Any, arguments: list[ir.Value]) -> ir.Value:
        *_, levels, wide, _, near = arguments
        lowest = None
        for channel, vectors in enumerate(_samples(builder, arguments)):
            for vector in vectors:
                halves = builder.bitcast(vector, HALVES)  # the lower ones are fractions, the upper ones far larger
                lowest = halves if lowest is None else _smaller(builder, halves, lowest)
            one, other = _overlaid(builder, *vectors[:2]), _overlaid(builder, *vectors[2:])
            bytes_ = builder.or_(builder.and_(one, _all(HALVES, 255)), builder.shl(other, _all(HALVES, 8)))
            bytes_ = builder.bitcast(bytes_, BYTES)
            ordered = builder.shuffle_vector(bytes_, bytes_, IN_ORDER)
            place = _moved(builder, levels, wide, channel)
            builder.store(ordered, builder.inttoptr(place, BYTES.as_pointer()), align=1)
        limit = _spread(builder, builder.trunc(_doubled(builder, near), HALF), HALVES)
        close = builder.icmp_unsigned("<", lowest, limit)
        return builder.icmp_unsigned("!=", builder.bitcast(close, HALF), ir.Constant(HALF, 0))

    return types.boolean(t, differences, levels, wide, bases, near), build


@intrinsic
def _close_pixels(typing, t, differences, levels, wide, bases, near) -> tuple[types.Type, Callable]:
    """Which pixels of a block have a sample near a step: uint32, the first pixel lowest; as in `_composite_block`."""

    def build(context: Any, builder: ir.IRBuilder, signature: Any, arguments: list[ir.Value]) -> ir.Value:
        lowest: list[Any] = [None] * 4
        for vectors in _samples(builder, arguments):
            for number, vector in enumerate(vectors):
                fraction = builder.and_(vector, _all(WORDS, 0xFFFF))
                before = lowest[number]
                lowest[number] = fraction if before is None else _smaller(builder, fraction, before)
        limit = _spread(builder, _doubled(builder, arguments[-1]), WORDS)
        mask = ir.Constant(WORD, 0)
        for number, fractions in enumerate(lowest):
            bits = builder.zext(builder.bitcast(builder.icmp_unsigned("<", fractions, limit), BYTE), WORD)
            mask = builder.or_(mask, builder.shl(bits, ir.Constant(WORD, 8 * number)))
        return mask

    return types.uint32(t, differences, levels, wide, bases, near), build


def _samples(builder: ir.IRBuilder, arguments: list[ir.Value]) -> Iterator[list[ir.Value]]:
    """For each channel the samples' bits times 2, four vectors: the upper half of each word ends in its level."""
    t, differences, _, wide, bases, _ = arguments
    shares = _loaded(builder, t)
    for channel in range(3):
        base = _spread(builder, builder.extract_value(bases, channel), FLOATS)
        place = _moved(builder, differences, builder.mul(wide, ir.Constant(ADDRESS, 4)), channel)
        vectors = []
        for share, difference in zip(shares, _loaded(builder, place), strict=True):
            # In one step or in two, as the processor can.
            product = builder.fmul(share, difference, flags=("contract",))
            sample = builder.fadd(product, base, flags=("contract",))
            vectors.append(builder.shl(builder.bitcast(sample, WORDS), _all(WORDS, 1)))
        yield vectors


def _overlaid(builder: ir.IRBuilder, one: ir.Value, other: ir.Value) -> ir.Value:
    """The upper halves of two vectors' words, those of the first as lower halves."""
    upper = builder.and_(other, _all(WORDS, 0xFFFF0000))
    return builder.bitcast(builder.or_(builder.lshr(one, _all(WORDS, 16)), upper), HALVES)


def _loaded(builder: ir.IRBuilder, address: ir.Value) -> list[ir.Value]:
    places = [builder.add(address, ir.Constant(ADDRESS, 32 * number)) for number in range(4)]
    return [builder.load(builder.inttoptr(place, FLOATS.as_pointer()), align=4) for place in places]


def _moved(builder: ir.IRBuilder, address: ir.Value, step: ir.Value, times: int) -> ir.Value:
    return builder.add(address, builder.mul(step, ir.Constant(ADDRESS, times)))


def _doubled(builder: ir.IRBuilder, value: ir.Value) -> ir.Value:
    return builder.shl(value, ir.Constant(value.type, 1))


def _smaller(builder: ir.IRBuilder, one: ir.Value, other: ir.Value) -> ir.Value:
    return builder.select(builder.icmp_unsigned("<", one, other), one, other)


def _all(kind: ir.VectorType, value: int) -> ir.Constant:
    return ir.Constant(kind, [value] * kind.count)


def _spread(builder: ir.IRBuilder, value: ir.Value, kind: ir.VectorType) -> ir.Value:
    single = builder.insert_element(ir.Constant(kind, ir.Undefined), value, ir.Constant(WORD, 0))
    return builder.shuffle_vector(single, single, _all(ir.VectorType(WORD, kind.count), 0))


@jit
def _differences(pixels, y, light, out):
    """A row of pixels, uint8 (H, 3 W), minus the airlight, as planes of colour, float32 (3, W)."""
    colour = light[0], light[1], light[2]
    width, wide = pixels.shape[1] // 3, out.shape[1]
    row = pixels.ctypes.data + y * pixels.strides[0]
    for x in range(0, width - 7, 8):
        _difference_vectors(row + 3 * x, colour, out.ctypes.data + 4 * x, wide)
    for x in range(width // 8 * 8, width):
        for c in range(3):
            out[c, x] = F(pixels[y, 3 * x + c]) - colour[c]


@jit
def _mix_filtered(planes, out):
    """Planes of colour, uint8 (3, W), as a PNG's scan line with the filter Sub, uint8 (1 + 3 W,)."""
    out[0], out[1], out[2], out[3] = SUB_FILTER, planes[0, 0], planes[1, 0], planes[2, 0]
    pairs, wide = out.size // 3 - 1, planes.shape[1]
    place, line = planes.ctypes.data, out.ctypes.data + 4
    if pairs < BLOCK:
        for x in range(pairs):
            for c in range(3):
                out[3 * x + 4 + c] = planes[c, x + 1] - planes[c, x]
        return
    for x in (0, pairs - BLOCK):
        _subtract_block(place + x, wide, line + 3 * x)
    # Vectors that begin at no whole 16 bytes take half as long again to write. 3 * 11 is 1, modulo 16.
    for x in range(-11 * line % 16, pairs - BLOCK, BLOCK):
        _subtract_block(place + x, wide, line + 3 * x)


@jit
def _composite(places, base, near, first, last, found):
    """Composite blocks; those that have samples near a step go to `found`. Returns their number."""
    t, differences, levels, wide = places
    count = 0
    for x in range(first, last, BLOCK):
        found[count] = x
        count += _composite_block(t + 4 * x, differences + 4 * x, levels + x, wide, base, near)
    return count


@jit
def _close(places, base, near, x):
    t, differences, levels, wide = places
    return _close_pixels(t + 4 * x, differences + 4 * x, levels + x, wide, base, near)


@jit
def _exact(image, depth, y, x, row, column, scale, beta, airlight, levels):
    """Composite one pixel in float64, as published."""
    t = math.exp(-beta * (depth[y, x] * math.sqrt((row + column) / scale)))
    for c in range(3):
        radiance = t * (image[y, 3 * x + c] / 255.0) + (1.0 - t) * (airlight[c] / 255.0)
        levels[c, x] = np.uint8(math.floor(255.0 * radiance + 0.5))


@jit
def render(image, depth, rows, out, filtered, row, geometry, fog, lights, found):
    (columns, scale, columns32), (airlight, light) = geometry, lights
    order, betas, plain, exponents, squares, bases, nears = fog
    distance, nearest, t, differences, levels = row
    ranks, ranked = distance.view(I), nearest.view(I)
    places = t.ctypes.data, differences.ctypes.data, levels.ctypes.data, t.size
    width = columns.size
    stride = 3 * width + filtered
    for y in range(rows.size):
        _distances(depth, y, F(rows[y] / scale), columns32, distance)
        _nearest(ranks, ranked)
        _differences(image, y, light, differences)
        for b in range(betas.size):
            base = bases[b, 0], bases[b, 1], bases[b, 2]
            near = nears[b]
            group = 0
            if betas[b] == 0:  # no fog: also at infinite distance the image itself
                _split(image, y, levels)
                group = nearest.size
            elif plain[b]:
                for x in range(width):
                    _exact(image, depth, y, x, rows[y], columns[x], scale, betas[b], airlight, levels)
                group = nearest.size
            while group < nearest.size:
                hidden, end = _span(exponents[b], nearest, group)
                start, stop, group = group * GROUP, end * GROUP, end
                first, last = np.uint64(start), np.uint64(stop)  # unsigned: the loops need no check for less than 0
                if hidden:
                    _fill(airlight, first, last, levels)
                    continue
                if squares[b]:
                    square(t, first, last)
                else:
                    transmittances(distance, exponents[b], first, last, t)
                for i in range(_composite(places, base, near, start, stop, found)):
                    block = found[i]
                    mask = _close(places, base, near, block)
                    for x in range(block, min(block + BLOCK, width)):
                        if mask >> U(x - block) & U(1):
                            _exact(image, depth, y, x, rows[y], columns[x], scale, betas[b], airlight, levels)
            line = out[order[b], y * stride : (y + 1) * stride]
            if filtered:
                _mix_filtered(levels, line)
            else:
                _mix(levels, line)
