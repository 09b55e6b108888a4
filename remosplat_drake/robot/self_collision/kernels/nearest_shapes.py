"""The nearest shapes of two links, in many configurations."""

import numpy as np

from remosplat_drake.base.kernels import kernel
from remosplat_drake.robot.self_collision.kernels.gjk import make_work
from remosplat_drake.robot.self_collision.kernels.pair_distance import (
    least_distance,
    place_center,
    shape_distance,
)


@kernel
def nearest_shapes(pairs, link, X_WLs, within):
    """Finds the nearest points of two links in m configurations.

    Args:
        pairs: Pairs of shapes, as packed `PairArrays`.
        link: Index of the pair of links.
        X_WLs: Poses of all bodies, shape (m, b, 4, 4).
        within: Links at or beyond this distance are left out [m].

    Returns:
        For each of the n configurations in which the links are near: its index,
        shape (n,); the nearest pair of shapes, shape (n,); their distance,
        shape (n,) [m]; and the nearest points of both in the frame of the first
        link, shape (n, 2, 3) [m]. Points of round shapes lie a radius inside
        the shape.
    """
    first, second, start = pairs.first, pairs.second, pairs.start
    shapes, link_boxes = pairs.shapes, pairs.link_boxes
    body, allowance = shapes.body, pairs.allowance
    m, n = len(X_WLs), start[link + 1] - start[link]
    which, nearest = np.empty(m, np.int64), np.empty(m, np.int64)
    distance, points = np.empty(m), np.empty((m, 2, 3))
    least, guess_W = np.empty(n), np.empty(3)
    p_WC, p_WL = np.empty((len(body), 3)), np.empty((len(link_boxes.body), 3))
    a, b = pairs.boxes[link]
    work = make_work()
    count = 0
    for row in range(m):
        X_WL = X_WLs[row]
        place_center(link_boxes, X_WL, a, p_WL)
        place_center(link_boxes, X_WL, b, p_WL)
        if least_distance(link_boxes, X_WL, p_WL, a, b) >= within:
            continue
        for i in range(n):
            k = start[link] + i
            # Places each shape of the two links once.
            if i == 0 or first[k] != first[k - 1]:
                place_center(shapes, X_WL, first[k], p_WC)
            if first[k] == first[start[link]]:
                place_center(shapes, X_WL, second[k], p_WC)
            apart = least_distance(shapes, X_WL, p_WC, first[k], second[k])
            least[i] = apart + allowance[k]
        best = within
        for _ in range(n):
            i = least.argmin()
            if least[i] >= best:
                break
            least[i] = np.inf
            k = start[link] + i
            for c in range(3):
                guess_W[c] = p_WC[second[k], c] - p_WC[first[k], c]
            gap, _, _, _ = shape_distance(
                shapes,
                X_WL[body[first[k]]],
                X_WL[body[second[k]]],
                (first[k], second[k]),
                guess_W,
                best - allowance[k],
                work,
            )
            if gap + allowance[k] < best:
                best = gap + allowance[k]
                which[count], nearest[count] = row, k
                distance[count] = best
                points[count, 0], points[count, 1] = work[-1][0], work[-1][1]
        if best < within:
            count += 1
    return which[:count], nearest[:count], distance[:count], points[:count]
