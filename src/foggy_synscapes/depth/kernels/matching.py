"""Greedy matching: segments without depth take the plane of the most similar one that has it, the surest first."""

import numpy as np

from foggy_synscapes.jit import jit


@jit
def segment_means(lab, begin, rows, columns, colours, centroids):
    """Mean colour, float64 (K, 3), and centroid, float64 (K, 2), column and row counted from 1, of each segment.

    lab : float64 (H, W, 3); begin, rows, columns : of `planes.pixels_of_segments`
    """
    for k in range(begin.size - 1):
        size = begin[k + 1] - begin[k]
        light = red = blue = across = down = 0.0
        for i in range(begin[k], begin[k + 1]):
            pixel = lab[rows[i], columns[i]]
            light, red, blue = light + pixel[0], red + pixel[1], blue + pixel[2]
            across, down = across + columns[i] + 1, down + rows[i] + 1
        colours[k, 0], colours[k, 1], colours[k, 2] = light / size, red / size, blue / size
        centroids[k, 0], centroids[k, 1] = across / size, down / size


@jit
def match(colours, centroids, seen, nearness, partners):
    """Partner of each segment without a plane, to `partners` (int32 (K,), -1 for the others); returns their order.

    seen : bool (K,), has a plane; at least one has
    nearness : weight of a squared distance in pixels against one in Lab
    """
    visible, unseen = np.flatnonzero(seen), np.flatnonzero(~seen)
    size = unseen.size
    cost, order, matched = np.empty(size), np.empty(size, np.int64), np.zeros(size, np.bool_)
    from_visible = np.empty(size)
    partners[:] = -1
    for i in range(size):
        from_visible[i] = np.inf
        for k in visible:
            difference = _difference(colours, centroids, k, unseen[i], nearness)
            if difference < from_visible[i]:
                from_visible[i] = difference
                partners[unseen[i]] = k
        cost[i] = from_visible[i]
    for turn in range(size):
        best = -1
        for i in range(size):
            if not matched[i] and (best < 0 or cost[i] < cost[best]):
                best = i
        order[turn] = unseen[best]
        matched[best] = True
        for i in range(size):
            if matched[i]:
                continue
            difference = _difference(colours, centroids, unseen[best], unseen[i], nearness)
            if difference < cost[i]:  # equal: the visible segment, or the one matched before, stays
                cost[i] = difference
                partners[unseen[i]] = unseen[best]
    return order


@jit
def _difference(colours, centroids, k, other, nearness):
    colour = place = 0.0
    for c in range(3):
        colour += (colours[k, c] - colours[other, c]) ** 2
    for c in range(2):
        place += (centroids[k, c] - centroids[other, c]) ** 2
    return colour + nearness * place
