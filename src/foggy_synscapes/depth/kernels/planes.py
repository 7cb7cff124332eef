"""Planes of segments by RANSAC, depth = a x + b y + c, x and y counted from 1; and depth filled from them."""

import numpy as np

from foggy_synscapes.depth.kernels import twister
from foggy_synscapes.jit import jit

MOST_ROUNDS, SURE = 2000, 0.99
TOLERANCE = 0.01  # of a segment's median depth: farther from its plane, a pixel is no inlier
OUTLIER = 50.0  # metres from the plane: what a known depth may differ
LEAST_KNOWN, LEAST_SHARE = 20, 0.6  # of a segment's pixels, for a plane of its own
BLOCK = 128

UNSEEN, FITTED, INFINITE = 0, 1, 2


@jit
def pixels_of_segments(labels, count):
    """Pixels by segment, column after column: where each segment begins, int64 (count + 1,), rows, columns (int32)."""
    begin = np.zeros(count + 1, np.int64)
    for y in range(labels.shape[0]):
        for x in range(labels.shape[1]):
            begin[labels[y, x] + 1] += 1
    for k in range(count):
        begin[k + 1] += begin[k]
    place = begin[:-1].copy()
    rows, columns = np.empty(labels.size, np.int32), np.empty(labels.size, np.int32)
    across = labels.T.copy()
    for x in range(labels.shape[1]):
        for y in range(labels.shape[0]):
            k = across[x, y]
            rows[place[k]], columns[place[k]] = y, x
            place[k] += 1
    return begin, rows, columns


@jit
def fit_segments(
    depth, unreliable, begin, rows, columns, seed, planes, states, rounds, inliers, least_share=LEAST_SHARE
):
    """Planes of the segments that have enough reliable depth; fills these segments. Returns how many draws it took.

    depth : float64 (H, W), metres, filled in place; unreliable : bool (H, W)
    begin, rows, columns : of `pixels_of_segments`
    planes : float64 (K, 3), states : uint8 (K,), rounds, inliers : int32 (K,), 0 where there was no RANSAC; written
    least_share : of a segment's pixels that have to be reliable
    """
    count = begin.size - 1
    most = 0
    for k in range(count):
        most = max(most, begin[k + 1] - begin[k])
    x, y, z, near = np.empty(most), np.empty(most), np.empty(most), np.empty(most, np.bool_)
    words, high = np.empty((2, twister.WORDS), np.uint32), np.empty(twister.DRAWS, np.uint32)
    words[0] = twister.seeded(seed)
    at, draws = twister.DRAWS, 0
    for k in range(count):
        finite = infinite = 0
        for i in range(begin[k], begin[k + 1]):
            row, column = rows[i], columns[i]
            if unreliable[row, column]:
                continue
            if depth[row, column] < np.inf:
                x[finite], y[finite], z[finite] = column + 1.0, row + 1.0, depth[row, column]
                finite += 1
            else:
                infinite += 1
        known, size = finite + infinite, begin[k + 1] - begin[k]
        if known < LEAST_KNOWN or known < least_share * size:
            continue
        if infinite <= finite:
            if _on_a_line(x[:finite], y[:finite]):  # no three points span a plane
                continue
            at, used = _ransac(x[:finite], y[:finite], z[:finite], near, words, high, at, planes[k], rounds[k : k + 1])
            draws += used
            inliers[k] = np.count_nonzero(near[:finite])
        states[k] = INFINITE if infinite > inliers[k] else FITTED
        if states[k] == INFINITE:
            planes[k] = np.inf
        fill(depth, unreliable, rows[begin[k] : begin[k + 1]], columns[begin[k] : begin[k + 1]], planes[k])
    return draws


@jit
def fill(depth, unreliable, rows, columns, plane):
    """Give a segment's unreliable pixels the depth of a plane, and the known ones that are more than 50 m off."""
    for i in range(rows.size):
        row, column = rows[i], columns[i]
        value = plane[0] if plane[0] == np.inf else plane[0] * (column + 1.0) + plane[1] * (row + 1.0) + plane[2]
        value = max(value, 0.0)
        # Where both are infinite the difference is not a number, and nothing happens.
        if unreliable[row, column] or abs(value - depth[row, column]) > OUTLIER:
            depth[row, column] = value


@jit
def _on_a_line(x, y):
    across, down = x[1] - x[0], y[1] - y[0]  # pixels differ, so the first two give the direction
    aside = 0
    for i in range(2, x.size):
        aside += across * (y[i] - y[0]) != (x[i] - x[0]) * down
    return aside == 0


@jit
def _ransac(x, y, z, near, words, high, at, plane, rounds):
    """Least-squares plane of the largest set of inliers found, which `near` then marks; see `fit_segments`."""
    tolerance, size, draws, best = TOLERANCE * np.median(z), x.size, 0, 0
    found = np.zeros(3, np.int64)
    fit, chosen = np.empty(3), np.empty(3)
    done = 0
    while done < MOST_ROUNDS:
        at = twister.sample(words, high, at, size, found)
        draws += size
        if not _through(x, y, z, found, fit):
            continue
        done += 1
        count = _count(x, y, z, fit, tolerance, best)
        if count > best:
            best = count
            chosen[:] = fit
        if 1 - (1 - (best / size) ** 3) ** done >= SURE:
            break
    a, b, c = chosen
    for i in range(size):
        near[i] = abs(a * x[i] + b * y[i] + c - z[i]) <= tolerance
    _least_squares(x, y, z, near, plane)
    rounds[0] = done
    return at, draws


@jit
def _through(x, y, z, three, plane):
    """The plane through three points; False where they lie on one line (their coordinates are whole numbers)."""
    i, j, k = three
    x1, y1, z1 = x[j] - x[i], y[j] - y[i], z[j] - z[i]
    x2, y2, z2 = x[k] - x[i], y[k] - y[i], z[k] - z[i]
    area = x1 * y2 - x2 * y1
    if area == 0:
        return False
    plane[0] = (z1 * y2 - z2 * y1) / area
    plane[1] = (x1 * z2 - x2 * z1) / area
    plane[2] = z[i] - plane[0] * x[i] - plane[1] * y[i]
    return True


@jit
def _count(x, y, z, plane, tolerance, best):
    """How many points lie near a plane; less than that where they cannot be more than `best`."""
    a, b, c = plane
    count, size = 0, x.size
    for begin in range(0, size, BLOCK):
        if count + size - begin <= best:
            return count
        last = min(begin + BLOCK, size)
        xs, ys, zs = x[begin:last], y[begin:last], z[begin:last]
        for i in range(xs.size):
            count += abs(a * xs[i] + b * ys[i] + c - zs[i]) <= tolerance
    return count


@jit
def _least_squares(x, y, z, near, plane):
    """The plane with the least squared error in depth, from sums around the mean, where little cancels."""
    count, mx, my, mz = 0, 0.0, 0.0, 0.0
    for i in range(x.size):
        if near[i]:
            count += 1
            mx, my, mz = mx + x[i], my + y[i], mz + z[i]
    mx, my, mz = mx / count, my / count, mz / count
    xx = xy = yy = xz = yz = 0.0
    for i in range(x.size):
        if near[i]:
            dx, dy, dz = x[i] - mx, y[i] - my, z[i] - mz
            xx, xy, yy = xx + dx * dx, xy + dx * dy, yy + dy * dy
            xz, yz = xz + dx * dz, yz + dy * dz
    area = xx * yy - xy * xy
    plane[0] = (xz * yy - yz * xy) / area
    plane[1] = (yz * xx - xz * xy) / area
    plane[2] = mz - plane[0] * mx - plane[1] * my
