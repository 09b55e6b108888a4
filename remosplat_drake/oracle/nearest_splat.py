"""Nearest splat of many points: ordered descent through the hierarchy.

All kernels here work on plain arrays. A splat is a record of 16 numbers in
leaf order: centre p_WK, the columns of R_WK sorted by falling semi-axis, the
three semi-axes (the last 0 for a disc) and the splat's index.
"""

import math

import numpy as np
from numba import njit, prange

from remosplat_drake.oracle.ellipsoid_distance import (
    box_distance_squared,
    closest_on_disc,
    closest_on_ellipsoid,
)
from remosplat_drake.splat.bvh import MAX_DEPTH, leaf_range

_SLACK = 1.0 + 1e-12
"""Bounds are compared with this margin: rounding never hides a splat."""

_CHUNK = 8
"""Neighbouring spheres that one thread answers in a row."""


@njit(cache=True, nogil=True)
def query(nodes, links, records, is_surfel, steps, spheres, answer):
    """Finds the nearest splat of every sphere.

    Args:
        nodes: As in `BoundingVolumeHierarchy`.
        links: As in `BoundingVolumeHierarchy`.
        records: Splats in leaf order, shape (N, 16).
        is_surfel: The splats are discs, not ellipsoids.
        steps: Bisection steps, or CONVERGE.
        spheres: (n, 5): centre p_WS, the distance from the centre that an
            answer must undercut, the height below which splats are unseen.
        answer: (n, 8), filled: splat index or -1, signed distance from the
            centre, p_WC, n_W.
    """
    _query_range(
        nodes, links, records, is_surfel, steps, spheres, answer, 0, len(answer)
    )


@njit(cache=True, parallel=True)
def query_parallel(nodes, links, records, is_surfel, steps, spheres, answer):
    """The same as `query` on several threads, with equal answers."""
    n = len(answer)
    for chunk in prange((n + _CHUNK - 1) // _CHUNK):
        start = chunk * _CHUNK
        _query_range(
            nodes,
            links,
            records,
            is_surfel,
            steps,
            spheres,
            answer,
            start,
            min(start + _CHUNK, n),
        )


@njit(cache=True)
def query_every_splat(records, is_surfel, steps, spheres, answer):
    """The same as `query` by trying all pairs: what the hierarchy must equal.

    The records are by splat index here, so the first of several nearest
    splats has the lowest one.
    """
    for i in range(len(answer)):
        p = (spheres[i, 0], spheres[i, 1], spheres[i, 2])
        nearest = -1
        best = spheres[i, 3]
        for place in range(len(records)):
            if records[place, 2] < spheres[i, 4]:
                continue
            y, e = _in_splat_frame(records[place], p)
            distance, _ = _closest_on_splat(y, e, is_surfel, steps)
            if distance < best:
                best, nearest = distance, place
        answer[i, 0] = -1.0
        if nearest >= 0:
            _write_answer(records[nearest], is_surfel, steps, p, answer[i])


@njit(cache=True, nogil=True)
def _query_range(
    nodes, links, records, is_surfel, steps, spheres, answer, start, stop
):
    stack = np.empty(MAX_DEPTH + 1, np.int64)
    bounds = np.empty(MAX_DEPTH + 1)
    place = -1
    for i in range(start, stop):
        p = (spheres[i, 0], spheres[i, 1], spheres[i, 2])
        limit, floor = spheres[i, 3], spheres[i, 4]
        best = (limit, -1)
        # Neighbouring spheres often share their splat, so try it first.
        if place >= 0:
            best = _nearer(records, place, is_surfel, steps, p, floor, best)
        best = _descend(
            nodes,
            links,
            records,
            is_surfel,
            steps,
            p,
            floor,
            best,
            stack,
            bounds,
        )
        answer[i, 0] = -1.0
        if best[1] >= 0:
            place = best[1]
            _write_answer(records[place], is_surfel, steps, p, answer[i])


@njit(cache=True)
def _descend(
    nodes, links, records, is_surfel, steps, p, floor, best, stack, bounds
):
    """Visits boxes nearest first while they may hold a nearer splat."""
    stack[0], bounds[0] = 0, 0.0
    height = 1
    while height:
        height -= 1
        link = stack[height]
        reach = max(best[0], 0.0)
        limit = reach * reach * _SLACK
        if bounds[height] > limit:
            continue
        if link < 0:
            first, end = leaf_range(link)
            for place in range(first, end):
                best = _nearer(records, place, is_surfel, steps, p, floor, best)
            continue
        left = _node_distance_squared(nodes, link, 0, p)
        right = _node_distance_squared(nodes, link, 6, p)
        far = 1 if left <= right else 0
        for side in (far, 1 - far):
            bound = right if side else left
            if bound <= limit and nodes[link, 12 + side] >= floor:
                stack[height], bounds[height] = links[link, 14 + side], bound
                height += 1
    return best


@njit(cache=True)
def _node_distance_squared(nodes, node, column, p) -> float:
    total = 0.0
    for k in range(3):
        below = nodes[node, column + k] - p[k]
        above = p[k] - nodes[node, column + 3 + k]
        outside = max(below, above, 0.0)
        total += outside * outside
    return total


@njit(cache=True)
def _nearer(records, place, is_surfel, steps, p, floor, best):
    """The better of `best` = (signed distance, place) and one splat."""
    splat = records[place]
    if splat[2] < floor:
        return best
    y, e = _in_splat_frame(splat, p)
    reach = max(best[0], 0.0)
    if box_distance_squared(y, e) > reach * reach * _SLACK:
        return best
    distance, _ = _closest_on_splat(y, e, is_surfel, steps)
    if distance < best[0]:
        return distance, place
    # A tie goes to the lowest index, whatever the order of the visits.
    if (
        distance == best[0]
        and best[1] >= 0
        and splat[15] < records[best[1], 15]
    ):
        return distance, place
    return best


@njit(cache=True)
def _in_splat_frame(splat, p):
    """The point p_W in the splat's frame, and the semi-axes."""
    x, y, z = p[0] - splat[0], p[1] - splat[1], p[2] - splat[2]
    return (
        splat[3] * x + splat[4] * y + splat[5] * z,
        splat[6] * x + splat[7] * y + splat[8] * z,
        splat[9] * x + splat[10] * y + splat[11] * z,
    ), (splat[12], splat[13], splat[14])


@njit(cache=True)
def _closest_on_splat(y, e, is_surfel, steps):
    if is_surfel:
        return closest_on_disc(y, e, steps)
    return closest_on_ellipsoid(y, e, steps)


@njit(cache=True)
def _write_answer(splat, is_surfel, steps, p, answer):
    y, e = _in_splat_frame(splat, p)
    distance, x = _closest_on_splat(y, e, is_surfel, steps)
    n = _direction(y, x, e, distance)
    answer[0] = splat[15]
    answer[1] = distance
    for k in range(3):
        answer[2 + k] = (
            splat[k]
            + splat[3 + k] * x[0]
            + splat[6 + k] * x[1]
            + splat[9 + k] * x[2]
        )
        answer[5 + k] = (
            splat[3 + k] * n[0] + splat[6 + k] * n[1] + splat[9 + k] * n[2]
        )


@njit(cache=True)
def _direction(y, x, e, distance):
    """Minus the gradient of the distance, in the splat's frame.

    On the surface x - y vanishes, and the surface's normal takes its place:
    the outward one of an ellipsoid, turned towards the scene; the disc's
    normal, axis 2, for a point on a disc.
    """
    if e[2] == 0.0 and distance == 0.0:
        return 0.0, 0.0, 1.0
    if e[2] > 0.0 and abs(distance) < 1e-8 * e[0]:
        u = -x[0] / e[0] * (e[2] / e[0])
        v = -x[1] / e[1] * (e[2] / e[1])
        w = -x[2] / e[2]
        length = math.sqrt(u * u + v * v + w * w)
        return u / length, v / length, w / length
    u, v, w = x[0] - y[0], x[1] - y[1], x[2] - y[2]
    length = math.copysign(math.sqrt(u * u + v * v + w * w), distance)
    return u / length, v / length, w / length
