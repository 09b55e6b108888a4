"""Finds the nearest splat of many points by branch and bound (Numba).

The kernels of this module work on plain arrays. Splats are sorted in leaf
order. Each splat is packed into 48 bytes (`pack_solids`), so that maps of whole
buildings fit into memory. A query unpacks only those splats that may be the
nearest (`solid`).

The uncertainty of a splat is subtracted from its distance, and the query finds
the smallest difference. The hierarchy's boxes are enlarged by the uncertainty
on all sides. So the distance to a box is a lower bound of the differences of
the splats in it.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import prange

from remosplat_drake.base.kernels import helper, kernel, parallel_kernel
from remosplat_drake.base.lanes import lowest_bit
from remosplat_drake.oracle.kernels.ellipsoid_distance import (
    box_distance_squared,
    closest_on_disc,
    closest_on_ellipsoid,
    is_inside,
)
from remosplat_drake.oracle.kernels.near_children import (
    around,
    lowered,
    near_children,
    node_address,
    raised,
)
from remosplat_drake.oracle.kernels.solid_records import (
    columns,
    falling,
    semi_axes,
    solid,
)
from remosplat_drake.oracle.kernels.wide_tree import MOST_WAITING, WIDTH
from remosplat_drake.signals.compiled_map import register_query
from remosplat_drake.splat.bvh import leaf_range

_SLACK = 1.0 + 1e-12
"""Relative margin of comparisons with bounds, so that rounding excludes no
splat."""

_ROUNDED_UP = 1.0 + 1e-15
"""Factor by which uncertainties are enlarged, so that rounding reduces none."""

_CHUNK = 8
"""Number of consecutive spheres that one thread processes."""


class SplatTree(NamedTuple):
    """The splats and the wide hierarchy that a query searches.

    Attributes:
        wide: Boxes of the wide hierarchy, see `widen`.
        children: Numbers of the children in the wide hierarchy; see `widen`.
        records: Splats in leaf order, packed by `pack_solids`, shape (N, 12).
        order: Index in the map of each of these splats, shape (N,).
        n_sigma: Length of a splat's semi-axes in standard deviations.
        is_surfel: Whether the splats are discs; otherwise they are ellipsoids.
        steps: Number of bisection steps, or CONVERGE.
    """

    wide: np.ndarray
    children: np.ndarray
    records: np.ndarray
    order: np.ndarray
    n_sigma: float
    is_surfel: bool
    steps: int


@kernel
def query(tree, spheres, answer):
    """Finds the nearest splat of every sphere.

    Args:
        tree: A `SplatTree`.
        spheres: Queries, shape (n, 6). The columns are the centre p_WS, the
            distance from the centre below which splats are searched, the height
            below which splats are ignored [m], and the index of the sphere.
        answer: Output, shape (n, 8). The columns are the index of the splat in
            the records (-1 without a result), the signed distance from the
            centre minus the splat's uncertainty, p_WC and n_W.
    """
    _query_range(tree, spheres, answer, 0, len(answer))


register_query(SplatTree, query)


@parallel_kernel
def query_parallel(tree, spheres, answer):
    """Finds the nearest splat of every sphere, on several threads.

    The arguments and the results are those of `query`.
    """
    n = len(answer)
    for chunk in prange((n + _CHUNK - 1) // _CHUNK):
        start = chunk * _CHUNK
        _query_range(tree, spheres, answer, start, min(start + _CHUNK, n))


@kernel
def query_every_splat(records, is_surfel, steps, spheres, answer):
    """Finds the nearest splat of every sphere by trying all pairs.

    This is the reference of `query`. The records are those of `open_solids`,
    sorted by the index of the splat. So if several splats are equally near, the
    splat with the lowest index is found.
    """
    for i in range(len(answer)):
        p = (spheres[i, 0], spheres[i, 1], spheres[i, 2])
        best = (spheres[i, 3], -1, (0.0, 0.0, 0.0))
        for place in range(len(records)):
            if records[place, 2] < spheres[i, 4]:
                continue
            y, e = _in_splat_frame(records[place], p)
            distance, x = _closest_on_splat(y, e, is_surfel, steps)
            distance -= records[place, 15]
            if distance < best[0]:
                best = (distance, place, x)
        answer[i, 0] = best[1]
        if best[1] >= 0:
            _write_answer(records[best[1]], p, best, answer[i])


@helper
def _query_range(tree, spheres, answer, start, stop):
    if len(tree.records) == 0:
        answer[start:stop, 0] = -1.0
        return
    waiting = np.empty(MOST_WAITING, np.int64)
    bounds = np.empty(MOST_WAITING, np.float32)
    squares = np.empty(WIDTH, np.float32)
    work = waiting, bounds, squares
    place = -1
    for i in range(start, stop):
        p = (spheres[i, 0], spheres[i, 1], spheres[i, 2])
        floor = spheres[i, 4]
        best = (spheres[i, 3], -1, (0.0, 0.0, 0.0))
        # Neighbouring spheres often have the same nearest splat, so the splat
        # of the previous sphere is tried first.
        if place >= 0:
            best = _nearer(tree, place, p, floor, best)
        best = _descend(tree, p, floor, best, work)
        answer[i, 0] = best[1]
        if best[1] >= 0:
            place = best[1]
            splat = solid(tree.records[place], tree.n_sigma)
            _write_answer(splat, p, best, answer[i])


@helper
def _descend(tree, p, floor, best, work):
    """Visits boxes, nearest first, if they may contain a nearer splat."""
    wide, children = tree.wide, tree.children
    waiting, bounds, squares = work
    x, x_up, y, y_up, z, z_up = around(p)
    low = lowered(floor)
    limit = raised(_limit(best[0]))
    waiting[0], bounds[0] = 0, 0.0
    height = 1
    while height:
        height -= 1
        if bounds[height] > limit:
            continue
        node = waiting[height]
        bits = near_children(  # pyright: ignore[reportCallIssue]
            node_address(wide, node),
            x,
            x_up,
            y,
            y_up,
            z,
            z_up,
            limit,
            low,
            squares.ctypes.data,
        )
        nearest, least, first = 0, np.float32(np.inf), height
        while bits:
            k = lowest_bit(bits)
            bits &= bits - 1
            child, square = children[node, k], squares[k]
            if child < 0:
                if square <= limit:
                    begin, end = leaf_range(child)
                    for place in range(begin, end):
                        best = _nearer(tree, place, p, floor, best)
                    limit = raised(_limit(best[0]))
                continue
            waiting[height], bounds[height] = child, square
            if square < least:
                least, nearest = square, height
            height += 1
        if height > first:
            last = height - 1
            waiting[nearest], waiting[last] = waiting[last], waiting[nearest]
            bounds[nearest], bounds[last] = bounds[last], bounds[nearest]
    return best


@helper
def _limit(distance) -> float:
    """Returns the squared distance beyond which no box contains a nearer splat.

    A negative distance occurs only inside of boxes that contain the point.
    """
    reach = max(distance, 0.0)
    return reach * reach * _SLACK


@helper
def _nearer(tree, place, p, floor, best):
    """Returns the nearer of two splats: the nearest so far, and another one.

    `best` describes the nearest splat so far: its distance minus its
    uncertainty, its index in the records, and the closest point in its frame.
    """
    packed = tree.records[place]
    if packed[2] < floor:
        return best
    d = p[0] - packed[0], p[1] - packed[1], p[2] - packed[2]
    e, uncertainty = semi_axes(packed, tree.n_sigma), np.float64(packed[10])
    # If the uncertainty is large, the rounding error of the difference is
    # large, too.
    reach = max(best[0] + uncertainty * _ROUNDED_UP, 0.0)
    # A bounding ball excludes most distant splats, which are then not unpacked.
    ball = reach + tree.n_sigma * np.float64(packed[11])
    if d[0] * d[0] + d[1] * d[1] + d[2] * d[2] > _limit(ball):
        return best
    limit = _limit(reach)
    y = _along(columns(packed), d)
    if box_distance_squared(y, e) > limit:
        return best
    e, y = falling(e, y)
    distance, x = _closest_on_splat(y, e, tree.is_surfel, tree.steps)
    distance -= uncertainty
    if distance < best[0]:
        return distance, place, x
    # Of equally near splats the one with the lowest index is chosen, so that
    # the result does not depend on the order of visits.
    tie = distance == best[0] and best[1] >= 0
    if tie and tree.order[place] < tree.order[best[1]]:
        return distance, place, x
    return best


@helper
def _along(axes, d):
    """Returns the components of a vector along three axes."""
    u, v, w = axes
    return (
        u[0] * d[0] + u[1] * d[1] + u[2] * d[2],
        v[0] * d[0] + v[1] * d[1] + v[2] * d[2],
        w[0] * d[0] + w[1] * d[1] + w[2] * d[2],
    )


@helper
def _in_splat_frame(splat, p):
    """Returns the point p_W in the splat's frame, and the semi-axes."""
    x, y, z = p[0] - splat[0], p[1] - splat[1], p[2] - splat[2]
    return (
        splat[3] * x + splat[4] * y + splat[5] * z,
        splat[6] * x + splat[7] * y + splat[8] * z,
        splat[9] * x + splat[10] * y + splat[11] * z,
    ), (splat[12], splat[13], splat[14])


@helper
def _closest_on_splat(y, e, is_surfel, steps):
    if is_surfel:
        return closest_on_disc(y, e, steps)
    return closest_on_ellipsoid(y, e, steps)


@helper
def _write_answer(splat, p, best, answer):
    """Writes the result of a query from `best`, see `_nearer`."""
    y, e = _in_splat_frame(splat, p)
    x = best[2]
    n = _direction(y, x, e)
    answer[1] = best[0]
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


@helper
def _direction(y, x, e):
    """Returns the direction from y to x: the distance's negative gradient.

    All vectors are in the splat's frame, and x is the point of the splat
    closest to y. If y is on the surface, x - y is zero. The direction is then
    the inward normal of the ellipsoid, or axis 2, the normal of the disc.
    """
    u, v, w = x[0] - y[0], x[1] - y[1], x[2] - y[2]
    largest = max(abs(u), max(abs(v), abs(w)))
    if e[2] == 0.0:
        if largest == 0.0:
            return 0.0, 0.0, 1.0
    elif largest < 1e-8 * e[0]:
        u = -x[0] / e[0] * (e[2] / e[0])
        v = -x[1] / e[1] * (e[2] / e[1])
        w = -x[2] / e[2]
        largest = max(abs(u), max(abs(v), abs(w)))
    elif is_inside(y, e):
        largest = -largest
    # The vector is scaled first, since squares of denormal numbers underflow.
    u, v, w = u / largest, v / largest, w / largest
    length = math.sqrt(u * u + v * v + w * w)
    return u / length, v / length, w / length
