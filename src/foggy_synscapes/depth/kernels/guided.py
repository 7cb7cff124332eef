"""The guided filter with a colour guide, by running sums over square windows whose border pixels are repeated.

Source: He, Sun and Tang, Guided Image Filtering, TPAMI 2013.
"""

import numpy as np

from foggy_synscapes.jit import jit

MOMENTS = 9  # three means, and of the inverse covariance what a symmetric matrix has


@jit
def moments(guide, level, radius, epsilon, out):
    """Mean colour around each pixel, and the inverse of its covariance plus epsilon: float64 (H, 9, W).

    guide : uint8 (H, W, 3); level : float64 (256,), value of each of its levels
    """
    height, width = guide.shape[:2]
    sums, line = np.zeros((MOMENTS, width)), np.empty(width + 2 * radius)
    values = np.empty((MOMENTS, width))
    for y in range(-radius, radius + 1):
        _products(guide, level, min(max(y, 0), height - 1), values)
        _add(values, sums, 1.0)
    area = 1.0 / (2 * radius + 1) ** 2
    for y in range(height):
        for c in range(MOMENTS):
            _across(sums[c], radius, area, line, out[y, c])
        _inverse(out[y], epsilon)
        _products(guide, level, max(y - radius, 0), values)
        _add(values, sums, -1.0)
        _products(guide, level, min(y + radius + 1, height - 1), values)
        _add(values, sums, 1.0)


@jit
def apply(guide, level, found, radius, source, out):
    """The filtered source, float64 (H, W): what a linear function of colour says that fits it around each pixel.

    found : of `moments`; source : float64 (H, W)
    """
    height, width = source.shape
    fits = np.empty((height, 4, width))
    sums, line, values = np.zeros((4, width)), np.empty(width + 2 * radius), np.empty((4, width))
    area = 1.0 / (2 * radius + 1) ** 2
    for y in range(-radius, radius + 1):
        _weighted(guide, level, source, min(max(y, 0), height - 1), values)
        _add(values, sums, 1.0)
    for y in range(height):
        for c in range(4):
            _across(sums[c], radius, area, line, fits[y, c])
        _fit(found[y], fits[y])
        _weighted(guide, level, source, max(y - radius, 0), values)
        _add(values, sums, -1.0)
        _weighted(guide, level, source, min(y + radius + 1, height - 1), values)
        _add(values, sums, 1.0)
    sums[:] = 0.0
    for y in range(-radius, radius + 1):
        _add(fits[min(max(y, 0), height - 1)], sums, 1.0)
    for y in range(height):
        for c in range(4):
            _across(sums[c], radius, area, line, values[c])
        for x in range(width):
            r, g, b = level[guide[y, x, 0]], level[guide[y, x, 1]], level[guide[y, x, 2]]
            out[y, x] = values[0, x] * r + values[1, x] * g + values[2, x] * b + values[3, x]
        _add(fits[max(y - radius, 0)], sums, -1.0)
        _add(fits[min(y + radius + 1, height - 1)], sums, 1.0)


@jit
def _products(guide, level, y, out):
    for x in range(out.shape[1]):
        r, g, b = level[guide[y, x, 0]], level[guide[y, x, 1]], level[guide[y, x, 2]]
        out[0, x], out[1, x], out[2, x] = r, g, b
        out[3, x], out[4, x], out[5, x] = r * r, r * g, r * b
        out[6, x], out[7, x], out[8, x] = g * g, g * b, b * b


@jit
def _weighted(guide, level, source, y, out):
    for x in range(out.shape[1]):
        value = source[y, x]
        for c in range(3):
            out[c, x] = level[guide[y, x, c]] * value
        out[3, x] = value


@jit
def _add(values, sums, sign):
    for c in range(sums.shape[0]):
        line, total = values[c], sums[c]
        for x in range(total.size):
            total[x] += sign * line[x]


@jit
def _across(sums, radius, area, line, out):
    """Mean over a window along a row, from sums over its columns."""
    width = sums.size
    for x in range(line.size):
        line[x] = sums[min(max(x - radius, 0), width - 1)]
    total = 0.0
    for x in range(2 * radius + 1):
        total += line[x]
    out[0] = total * area
    for x in range(1, width):
        total += line[x + 2 * radius] - line[x - 1]
        out[x] = total * area


@jit
def _inverse(means, epsilon):
    """In place: six means of products become the inverse of the covariance, its diagonal larger by epsilon."""
    for x in range(means.shape[1]):
        r, g, b = means[0, x], means[1, x], means[2, x]
        rr, rg, rb = means[3, x] - r * r + epsilon, means[4, x] - r * g, means[5, x] - r * b
        gg, gb, bb = means[6, x] - g * g + epsilon, means[7, x] - g * b, means[8, x] - b * b + epsilon
        one, two, three = gg * bb - gb * gb, gb * rb - rg * bb, rg * gb - gg * rb
        scale = 1.0 / (rr * one + rg * two + rb * three)
        means[3, x], means[4, x], means[5, x] = one * scale, two * scale, three * scale
        means[6, x], means[7, x] = (rr * bb - rb * rb) * scale, (rb * rg - rr * gb) * scale
        means[8, x] = (rr * gg - rg * rg) * scale


@jit
def _fit(found, means):
    """In place: means of colour times source, and of the source, become slope and offset of the linear function."""
    for x in range(means.shape[1]):
        r, g, b, mean = found[0, x], found[1, x], found[2, x], means[3, x]
        dr, dg, db = means[0, x] - r * mean, means[1, x] - g * mean, means[2, x] - b * mean
        one = found[3, x] * dr + found[4, x] * dg + found[5, x] * db
        two = found[4, x] * dr + found[6, x] * dg + found[7, x] * db
        three = found[5, x] * dr + found[7, x] * dg + found[8, x] * db
        means[0, x], means[1, x], means[2, x] = one, two, three
        means[3, x] = mean - one * r - two * g - three * b
