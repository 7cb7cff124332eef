"""The inner loops of fog that is not alike everywhere, compiled by Numba; see `uneven` for the formulas."""

import math

import numpy as np

from foggy_synscapes.jit import jit, jit_contracted

F, INT = np.float32, np.int32
LOG2E, LN2 = F(math.log2(math.e)), F(math.log(2))
# Adding 1.5 * 2^23 rounds to an integer, which then stands in the lowest bits.
ROUNDER, BIAS, EXPONENT = F(12582912.0), INT(127), INT(23)
DENSEST = F(-60.0)
"""Exponent below which exp is nothing beside 1."""
FARTHEST = F(1e30)
ONE, NONE = F(1.0), F(0.0)
AHEAD, ONE_CELL = 2**28, np.uint64(1)
# 1 / (n + 1)!: exp(r) - 1 = r (C0 + C1 r + ...), within 1e-8 of itself for |r| <= ln 2 / 2.
C0, C1, C2, C3, C4, C5, C6 = (F(1 / math.factorial(n + 1)) for n in range(7))


@jit_contracted
def layered(depth, rows, columns, scale, rises, lowest, density, out):
    """Effective distance through fog that thins with height, written to `out`, float32 (H, W).

    depth : float32 (H, W), planar metres; rows, columns, scale : of the rays; rises : float64 (H,), metres up per
        planar metre and scale height; lowest : -h0 / H; density : exp(-h0 / H)

    exp is written out, so that the compiler computes many pixels at a time. Arithmetic is float32, within 2e-6 of the
    formula: the product of a single beta and distance, 6 at most where it shows, is then off by 1e-5, or 0.003 levels.
    """
    height, width = depth.shape
    root = F(density / math.sqrt(scale))
    lowest, flat = F(lowest), columns.astype(F)
    for y in range(height):
        rise, row = F(rises[y]), F(rows[y])
        for x in range(width):
            metres = depth[y, x]
            metres = metres if metres < FARTHEST else FARTHEST
            z = rise * metres
            z = z if z > lowest else lowest
            e = -z
            e = e if e > DENSEST else DENSEST
            rounded = e * LOG2E + ROUNDER
            whole = rounded - ROUNDER
            r = e - whole * LN2
            poly = (((((C6 * r + C5) * r + C4) * r + C3) * r + C2) * r + C1) * r + C0
            power = INT((F(rounded).view(INT) + BIAS) << EXPONENT).view(F)
            # expm1(e) = 2^k expm1(r) + 2^k - 1; with k = 0, expm1(e) / e is the polynomial, also at e = 0.
            # np.divide does not look for zeros, which would keep the compiler from vectors.
            share = poly if whole == NONE else np.divide(power * (r * poly) + (power - ONE), -z)
            out[y, x] = metres * F(math.sqrt(row + flat[x])) * root * share


@jit
def uneven(depth, rows, columns, scale, across, down, grid, cell, offset, contrast, reach, steps, out):
    """Effective distance through noisy fog, rho = 1 + contrast * noise, by the midpoint rule; to `out`, float32 (H, W).

    grid : float32 (N, N, N), periodic, N a power of 2; cell : metres; offset : float64 (3,), cells
    across, down : per planar metre; reach : metres along the ray behind which density counts as its mean, 1
    """
    height, width = depth.shape
    size = np.uint64(grid.shape[0])
    mask, rows_of, cells = size - np.uint64(1), size * size, grid.ravel()
    # Whole periods ahead, so that no position is negative and its integer part is what a conversion leaves.
    narrow, per_step, share = 1.0 / scale, 1.0 / (steps * cell), contrast / steps
    start = offset + size * np.float64(AHEAD)
    for y in range(height):
        for x in range(width):
            factor = math.sqrt((rows[y] + columns[x]) * narrow)
            whole = min(np.float64(depth[y, x]), 1e30)
            near = min(whole, reach / factor)
            step = near * per_step
            ax, ay, az = across[x] * step, down[y] * step, step
            px, py, pz = start[0] + 0.5 * ax, start[1] + 0.5 * ay, start[2] + 0.5 * az
            total = F(0.0)
            for _ in range(steps):
                fx, fy, fz = np.uint64(px), np.uint64(py), np.uint64(pz)
                u, v, w = F(px - fx), F(py - fy), F(pz - fz)
                i, j, k = (fx & mask) * rows_of, (fy & mask) * size, fz & mask
                i1, j1, k1 = ((fx + ONE_CELL) & mask) * rows_of, ((fy + ONE_CELL) & mask) * size, (fz + ONE_CELL) & mask
                a = cells[i + j + k] + (cells[i + j + k1] - cells[i + j + k]) * w
                b = cells[i + j1 + k] + (cells[i + j1 + k1] - cells[i + j1 + k]) * w
                c = cells[i1 + j + k] + (cells[i1 + j + k1] - cells[i1 + j + k]) * w
                d = cells[i1 + j1 + k] + (cells[i1 + j1 + k1] - cells[i1 + j1 + k]) * w
                a += (b - a) * v
                c += (d - c) * v
                total += a + (c - a) * u
                px += ax
                py += ay
                pz += az
            out[y, x] = (whole + near * share * total) * factor
