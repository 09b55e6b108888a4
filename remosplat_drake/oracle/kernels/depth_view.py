"""`DepthViews`: the six depth views of one sphere, for kernels (numba).

Sets of views are written as bits: bit v is view v.
"""

from typing import NamedTuple

import numpy as np

from remosplat_drake.oracle.depth_sensor import N_VIEWS, R_DV
from remosplat_drake.oracle.kernels.footprints import (
    child_margin,
    inlined,
    kernel,
    lean,
)

ALL_VIEWS = 2**N_VIEWS - 1
"""The set of all views."""

# Unit normals of the six planes through the sensor's centre that are the
# sides of all views: every two axes of D have two bisecting planes.
_BORDERS_D = np.sqrt(0.5) * np.array(
    [[1, 1, 0], [1, -1, 0], [0, 1, 1], [0, 1, -1], [1, 0, 1], [-1, 0, 1]]
)
_AXES = R_DV[:, :, 2] @ _BORDERS_D.T
# The views that are left to what lies behind a border, and before it.
_VIEWS_BEHIND = ALL_VIEWS - (2 ** np.arange(N_VIEWS)) @ (_AXES > 0.5)
_VIEWS_BEFORE = ALL_VIEWS - (2 ** np.arange(N_VIEWS)) @ (_AXES < -0.5)


class DepthViews(NamedTuple):
    """The six views of one sphere.

    Attributes:
        p_WS: Camera centre of all of them, shape (3,) [m].
        R_WV: Their orientations, shape (6, 3, 3).
        borders_W: Unit normals of the planes between them, shape (6, 3).
        ignore_below: Splats with lower centres are not seen [m].
    """

    p_WS: np.ndarray
    R_WV: np.ndarray
    borders_W: np.ndarray
    ignore_below: float


@kernel
def make_views(p_WS, R_WD, ignore_below):
    """Makes the views of a sphere whose sensor has the orientation R_WD."""
    R_WV = np.zeros((N_VIEWS, 3, 3))
    borders_W = np.zeros((len(_BORDERS_D), 3))
    for i in range(3):
        for k in range(3):
            for v in range(N_VIEWS):
                for j in range(3):
                    R_WV[v, i, j] += R_WD[i, k] * R_DV[v, k, j]
            for b in range(len(_BORDERS_D)):
                borders_W[b, i] += R_WD[i, k] * _BORDERS_D[b, k]
    return DepthViews(p_WS, R_WV, borders_W, ignore_below)


@inlined
def views_of_ball(views, x, y, z, radius, seen):
    """Returns which views of the set `seen` meet a ball at p_WS + (x, y, z)."""
    for b in range(len(_BORDERS_D)):
        nx, ny, nz = (
            views.borders_W[b, 0],
            views.borders_W[b, 1],
            views.borders_W[b, 2],
        )
        height = nx * x + ny * y + nz * z
        if height < -radius:
            seen &= _VIEWS_BEHIND[b]
        if height > radius:
            seen &= _VIEWS_BEFORE[b]
    return seen


@inlined
def views_beyond(best, distance, seen):
    """Returns which views of the set `seen` look farther than `distance`."""
    for v in range(N_VIEWS):
        if distance >= best[v]:
            seen &= ~(1 << v)
    return seen


@inlined
def views_of_box(splats, link, side, views, seen, best, spread):
    """Bounds the ranges in a child's box, and finds the views that need it.

    Args:
        splats: The `Footprints`.
        link: Index of a node.
        side: Side of the child, 0 (left) or 1 (right).
        views: The views.
        seen: Set of the views that need the node.
        best: Range from which on each view needs nothing, shape (6,) [m].
        spread: Reach of the low-pass filter, see `Rules`.

    Returns:
        A lower bound of the ranges [m], and the set of views.
    """
    nodes = splats.nodes
    if nodes[link, 12 + side] < views.ignore_below:
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
    seen = views_beyond(best, nearest, seen)
    if seen == 0:
        return nearest, seen
    slack = 0.0
    if spread > 0:
        dx, dy, dz = abs(x) + hx, abs(y) + hy, abs(z) + hz
        slack = spread * np.sqrt(dx * dx + dy * dy + dz * dz)
    for b in range(len(_BORDERS_D)):
        nx, ny, nz = (
            views.borders_W[b, 0],
            views.borders_W[b, 1],
            views.borders_W[b, 2],
        )
        height = nx * x + ny * y + nz * z
        reach = abs(nx) * hx + abs(ny) * hy + abs(nz) * hz + slack
        if height < -reach:
            seen &= _VIEWS_BEHIND[b]
        if height > reach:
            seen &= _VIEWS_BEFORE[b]
    return nearest, seen


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
    if splats.nodes[link, 12 + side] < views.ignore_below:
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
