"""`View`: one depth view of one sphere, and boxes as it sees them (numba)."""

from typing import NamedTuple

import numpy as np

from remosplat_drake.oracle.footprints import kernel


class View(NamedTuple):
    """One view of one sphere.

    Attributes:
        p_WV: Camera centre, shape (3,) [m].
        R_WV: Its orientation, shape (3, 3).
        sides_W: Inward unit normals of the frustum's sides, shape (4, 3).
        ignore_below: Splats with lower centres are not seen [m].
    """

    p_WV: np.ndarray
    R_WV: np.ndarray
    sides_W: np.ndarray
    ignore_below: float


@kernel
def make_view(p_WS, R_WD, R_DV, ignore_below):
    """The view with orientation R_DV in a sphere's sensor."""
    R_WV = np.empty((3, 3))
    sides_W = np.empty((4, 3))
    for i in range(3):
        for j in range(3):
            R_WV[i, j] = (
                R_WD[i, 0] * R_DV[0, j]
                + R_WD[i, 1] * R_DV[1, j]
                + R_WD[i, 2] * R_DV[2, j]
            )
        for j in range(2):
            sides_W[2 * j, i] = (R_WV[i, 2] - R_WV[i, j]) * np.sqrt(0.5)
            sides_W[2 * j + 1, i] = (R_WV[i, 2] + R_WV[i, j]) * np.sqrt(0.5)
    return View(p_WS, R_WV, sides_W, ignore_below)


@kernel
def box_range(splats, link, side, view, spread):
    """Lower bound of the ranges in a child's box; inf if the view misses it."""
    if splats.nodes[link, 12 + side] < view.ignore_below:
        return np.inf
    column = 6 * side
    p = view.p_WV
    x_low, x_high = (
        splats.nodes[link, column] - p[0],
        splats.nodes[link, column + 3] - p[0],
    )
    y_low, y_high = (
        splats.nodes[link, column + 1] - p[1],
        splats.nodes[link, column + 4] - p[1],
    )
    z_low, z_high = (
        splats.nodes[link, column + 2] - p[2],
        splats.nodes[link, column + 5] - p[2],
    )
    slack = 0.0
    if spread > 0:
        x = max(-x_low, x_high)
        y = max(-y_low, y_high)
        z = max(-z_low, z_high)
        slack = spread * np.sqrt(x * x + y * y + z * z)
    for j in range(4):
        nx, ny, nz = view.sides_W[j, 0], view.sides_W[j, 1], view.sides_W[j, 2]
        farthest = nx * (x_high if nx > 0 else x_low)
        farthest += ny * (y_high if ny > 0 else y_low)
        farthest += nz * (z_high if nz > 0 else z_low)
        if farthest + slack < 0:
            return np.inf
    x = max(x_low, -x_high, 0.0)
    y = max(y_low, -y_high, 0.0)
    z = max(z_low, -z_high, 0.0)
    return np.sqrt(x * x + y * y + z * z) * max(1 - spread, 0.0)


@kernel
def ray_meets_box(splats, link, side, view, ray_W, rules):
    """Whether a ray passes a child's box (and its spread) in near to far."""
    if splats.nodes[link, 12 + side] < view.ignore_below:
        return False
    column = 6 * side
    slack = 0.0
    if rules.spread > 0:
        square = 0.0
        for i in range(3):
            low = splats.nodes[link, column + i] - view.p_WV[i]
            high = splats.nodes[link, column + 3 + i] - view.p_WV[i]
            square += max(-low, high) ** 2
        slack = rules.spread * np.sqrt(square)
    enter, leave = rules.near, rules.far
    for i in range(3):
        low = splats.nodes[link, column + i] - view.p_WV[i] - slack
        high = splats.nodes[link, column + 3 + i] - view.p_WV[i] + slack
        if ray_W[i] == 0:
            if low > 0 or high < 0:
                return False
            continue
        a, b = low / ray_W[i], high / ray_W[i]
        enter, leave = max(enter, min(a, b)), min(leave, max(a, b))
    return enter <= leave
