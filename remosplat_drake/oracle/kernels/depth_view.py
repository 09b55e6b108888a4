"""`DepthViews`: the six depth views of one sphere, for kernels (numba).

Sets of views are written as bits: bit v is view v. In the sensor's frame D each
view sees what is farther along its axis than along both others.
"""

from typing import NamedTuple

import numpy as np

from remosplat_drake.oracle.depth_sensor import N_VIEWS, R_DV
from remosplat_drake.oracle.kernels.footprints import (
    child_margin,
    inlined,
    lean,
)

ALL_VIEWS = 2**N_VIEWS - 1
"""The set of all views."""

# The views along and against each axis of D.
_ALONG_X, _ALONG_Y, _ALONG_Z, _AGAINST_X, _AGAINST_Y, _AGAINST_Z = (
    1 << int(np.argmax(R_DV[:, :, 2] @ axis))
    for axis in [*np.eye(3), *-np.eye(3)]
)

_ROOT_2 = np.sqrt(2.0)


class DepthViews(NamedTuple):
    """The six views of one sphere, which kernels place.

    Attributes:
        p_WS: Camera centre of all of them, shape (3,) [m].
        R_WD: Orientation of the sensor, shape (3, 3).
        R_WV: Orientations of the views, shape (6, 3, 3).
        ignore_below: Splats with lower centres are not seen, shape (1,) [m].
    """

    p_WS: np.ndarray
    R_WD: np.ndarray
    R_WV: np.ndarray
    ignore_below: np.ndarray


def new_views() -> DepthViews:
    """Makes views that are nowhere yet."""
    return DepthViews(
        np.zeros(3), np.zeros((3, 3)), np.zeros((N_VIEWS, 3, 3)), np.zeros(1)
    )


@lean
def place_views(views, p_WS, R_WD, ignore_below):
    """Places the views of a sphere whose sensor has the orientation R_WD."""
    views.ignore_below[0] = ignore_below
    for i in range(3):
        views.p_WS[i] = p_WS[i]
        for j in range(3):
            views.R_WD[i, j] = R_WD[i, j]
            for v in range(N_VIEWS):
                views.R_WV[v, i, j] = (
                    R_WD[i, 0] * R_DV[v, 0, j]
                    + R_WD[i, 1] * R_DV[v, 1, j]
                    + R_WD[i, 2] * R_DV[v, 2, j]
                )


@inlined
def views_of_ball(views, x, y, z, radius):
    """Returns the views that meet a ball at p_WS + (x, y, z)."""
    R_WD = views.R_WD
    x, y, z = (
        R_WD[0, 0] * x + R_WD[1, 0] * y + R_WD[2, 0] * z,
        R_WD[0, 1] * x + R_WD[1, 1] * y + R_WD[2, 1] * z,
        R_WD[0, 2] * x + R_WD[1, 2] * y + R_WD[2, 2] * z,
    )
    # Views are parted by planes at 45 degrees.
    reach = _ROOT_2 * radius
    return _views_beyond_sides(
        x, y, z, reach, reach, reach, abs(x), abs(y), abs(z)
    )


@inlined
def _views_of_block(views, x, y, z, hx, hy, hz, slack):
    """Returns the views that meet a box at p_WS + (x, y, z), along W.

    (hx, hy, hz) are half its edges; it is enlarged by `slack` all around.
    """
    R = views.R_WD
    hx, hy, hz, x, y, z = (
        abs(R[0, 0]) * hx + abs(R[1, 0]) * hy + abs(R[2, 0]) * hz + slack,
        abs(R[0, 1]) * hx + abs(R[1, 1]) * hy + abs(R[2, 1]) * hz + slack,
        abs(R[0, 2]) * hx + abs(R[1, 2]) * hy + abs(R[2, 2]) * hz + slack,
        R[0, 0] * x + R[1, 0] * y + R[2, 0] * z,
        R[0, 1] * x + R[1, 1] * y + R[2, 1] * z,
        R[0, 2] * x + R[1, 2] * y + R[2, 2] * z,
    )
    return _views_beyond_sides(
        x, y, z, hx, hy, hz, abs(x) - hx, abs(y) - hy, abs(z) - hz
    )


@inlined
def _views_beyond_sides(x, y, z, hx, hy, hz, ax, ay, az):
    """Returns the views of what reaches farther ahead than to the sides.

    It reaches by (hx, hy, hz) beyond (x, y, z), in D; (ax, ay, az) is how far
    it is at least from the planes across the axes.
    """
    beside_x = max(ay, az, 0.0)
    beside_y = max(az, ax, 0.0)
    beside_z = max(ax, ay, 0.0)
    seen = _ALONG_X if hx + x >= beside_x else 0
    seen |= _AGAINST_X if hx - x >= beside_x else 0
    seen |= _ALONG_Y if hy + y >= beside_y else 0
    seen |= _AGAINST_Y if hy - y >= beside_y else 0
    seen |= _ALONG_Z if hz + z >= beside_z else 0
    seen |= _AGAINST_Z if hz - z >= beside_z else 0
    return seen


@inlined
def views_beyond(limit, distance, seen):
    """Returns which views of the set `seen` look farther than `distance`."""
    for v in range(N_VIEWS):
        if distance >= limit[v]:
            seen &= ~(1 << v)
    return seen


@inlined
def views_of_box(splats, link, side, views, seen, limit, spread):
    """Bounds the ranges in a child's box, and finds the views that need it.

    Args:
        splats: The `Footprints`.
        link: Index of a node.
        side: Side of the child, 0 (left) or 1 (right).
        views: The views.
        seen: Set of the views that need the node.
        limit: Range from which on each view needs nothing, shape (6,) [m].
        spread: Reach of the low-pass filter, see `Rules`.

    Returns:
        A lower bound of the ranges [m], and the set of views.
    """
    nodes = splats.nodes
    if nodes[link, 12 + side] < views.ignore_below[0]:
        return np.inf, 0
    at = 6 * side
    p = views.p_WS
    x, hx = _middle(nodes[link, at] - p[0], nodes[link, at + 3] - p[0])
    y, hy = _middle(nodes[link, at + 1] - p[1], nodes[link, at + 4] - p[1])
    z, hz = _middle(nodes[link, at + 2] - p[2], nodes[link, at + 5] - p[2])
    dx = max(abs(x) - hx, 0.0)
    dy = max(abs(y) - hy, 0.0)
    dz = max(abs(z) - hz, 0.0)
    nearest = np.sqrt(dx * dx + dy * dy + dz * dz) * max(1 - spread, 0.0)
    nearest -= child_margin(splats, link, side)
    seen = views_beyond(limit, nearest, seen)
    if seen == 0:
        return nearest, seen
    slack = 0.0
    if spread > 0:
        dx, dy, dz = abs(x) + hx, abs(y) + hy, abs(z) + hz
        slack = spread * np.sqrt(dx * dx + dy * dy + dz * dz)
    return nearest, seen & _views_of_block(views, x, y, z, hx, hy, hz, slack)


@inlined
def _middle(low, high):
    """Centre and half length of an interval."""
    return 0.5 * (low + high), 0.5 * (high - low)


@lean
def ray_meets_box(splats, link, side, views, ray_W, rules):
    """Returns whether a ray meets a child's box between `near` and `far`.

    The box is enlarged by the spread of the low-pass filter, and may lie as
    far behind `far` as its splats are uncertain.
    """
    if splats.nodes[link, 12 + side] < views.ignore_below[0]:
        return False
    column = 6 * side
    slack = 0.0
    if rules.spread > 0:
        square = 0.0
        for i in range(3):
            low = splats.nodes[link, column + i] - views.p_WS[i]
            high = splats.nodes[link, column + 3 + i] - views.p_WS[i]
            square += max(-low, high) ** 2
        slack = rules.spread * np.sqrt(square)
    enter = rules.near
    leave = rules.far + child_margin(splats, link, side)
    for i in range(3):
        low = splats.nodes[link, column + i] - views.p_WS[i] - slack
        high = splats.nodes[link, column + 3 + i] - views.p_WS[i] + slack
        if ray_W[i] == 0:
            if low > 0 or high < 0:
                return False
            continue
        a, b = low / ray_W[i], high / ray_W[i]
        enter, leave = max(enter, min(a, b)), min(leave, max(a, b))
    return enter <= leave
