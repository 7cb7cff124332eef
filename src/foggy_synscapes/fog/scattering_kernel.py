"""The inner loop of fog with scattered light, compiled by Numba; see `scattering` for the formula."""

import math

import numpy as np

from foggy_synscapes.fog.kernel import transmittances
from foggy_synscapes.jit import jit

F = np.float32
LOG2E = math.log2(math.e)


@jit
def lit(pixels, depth, rows, columns, scale, betas, light, linear, glow, cell, share, levels, out):
    """Foggy pixels, written to `out`, uint8 (B, H, W, 3).

    pixels : uint8 (H, W, 3); depth : float32 (H, W), planar metres; rows, columns, scale : of the rays
    betas : float64 (B,), 1/m; light : float32 (3,), linear; linear : float32 (256,), radiance by level
    glow : float32 (h, w, 3), R - E blurred, of cells of `cell` pixels one beyond each side; share : of it
    levels : uint8, of radiance from 0 to 1 in equal steps
    """
    height, width = depth.shape
    size, last = F(levels.size - 1), np.int64(levels.size - 1)
    distance, t, line = np.empty(width, F), np.empty(width, F), np.empty((width, 3), F)
    for y in range(height):
        for x in range(width):
            distance[x] = depth[y, x] * math.sqrt((rows[y] + columns[x]) / scale)
        _between(glow, y, cell, line)
        for b in range(betas.size):
            if betas[b] == 0:
                out[b, y] = pixels[y]
                continue
            transmittances(distance, F(betas[b] * -LOG2E), 0, width, t)
            for x in range(width):
                through = t[x]
                lost = share * (F(1.0) - through)
                for c in range(3):
                    value = light[c] + through * (linear[pixels[y, x, c]] - light[c]) + lost * line[x, c]
                    place = np.int64(value * size + F(0.5))
                    out[b, y, x, c] = levels[min(max(place, 0), last)]


@jit
def _between(glow, y, cell, line):
    """One row of the blurred light, interpolated between the middles of its cells."""
    v = min(max((y + 0.5) / cell + 0.5, 0.0), glow.shape[0] - 1.0)
    j = min(int(v), max(glow.shape[0] - 2, 0))
    below = min(j + 1, glow.shape[0] - 1)
    q = F(v - j)
    for x in range(line.shape[0]):
        u = min(max((x + 0.5) / cell + 0.5, 0.0), glow.shape[1] - 1.0)
        i = min(int(u), max(glow.shape[1] - 2, 0))
        right = min(i + 1, glow.shape[1] - 1)
        p = F(u - i)
        for c in range(3):
            upper = glow[j, i, c] + (glow[j, right, c] - glow[j, i, c]) * p
            lower = glow[below, i, c] + (glow[below, right, c] - glow[below, i, c]) * p
            line[x, c] = upper + (lower - upper) * q
