"""Surface normals from a depth image.

Depth is rounded to millimetres, so close neighbouring pixels would give wrong
slopes. A normal is therefore computed from the most distant neighbours between
which the surface is smooth.
"""

import numpy as np

from remosplat_drake.base.kernels import numpy_helper, numpy_kernel

REACHES = (4, 2, 1)
"""Distances to the neighbours that determine a normal, best first [pixels]."""

MAX_BEND = 0.25
"""Largest bend of a surface for which a normal is computed. A larger bend is an
edge.

The bend is the length of p_1 + p_2 - 2 p, for a point p between opposite
neighbours p_1 and p_2, as a fraction of |p_1 - p_2|.
"""


def depth_normals(K: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """Computes unit normals in C, towards the camera, from a depth image.

    Args:
        K: Intrinsic matrix, shape (3, 3) [pixels].
        depth: Depth z in C, shape (h, w) [m]; 0 where unknown.

    Returns:
        Shape (h, w, 3), float32; NaN at the border, at edges and where depth is
        unknown.
    """
    camera = (K[0, 0], K[1, 1], K[0, 2], K[1, 2])
    normal = np.full((*depth.shape, 3), np.nan, np.float32)
    _fill_normals(camera, depth.astype(np.float64), REACHES, normal)
    return normal


@numpy_kernel
def _fill_normals(camera, depth, reaches, normal):
    height, width = depth.shape
    for row in range(height):
        for column in range(width):
            if depth[row, column] <= 0:
                continue
            for reach in reaches:
                if _span(camera, depth, row, column, reach, normal):
                    break


@numpy_helper
def _span(camera, depth, row, column, reach, normal):
    """Writes the normal from pixels `reach` away, if the surface is smooth."""
    height, width = depth.shape
    if not (reach <= row < height - reach and reach <= column < width - reach):
        return False
    x, y, z = _point(camera, depth, row, column)
    right = _point(camera, depth, row, column + reach)
    left = _point(camera, depth, row, column - reach)
    below = _point(camera, depth, row + reach, column)
    above = _point(camera, depth, row - reach, column)
    if min(right[2], left[2], below[2], above[2]) <= 0:
        return False
    ax, ay, az, is_straight = _step(right, left, x, y, z)
    if not is_straight:
        return False
    bx, by, bz, is_straight = _step(below, above, x, y, z)
    if not is_straight:
        return False
    nx, ny, nz = by * az - bz * ay, bz * ax - bx * az, bx * ay - by * ax
    length = np.sqrt(nx * nx + ny * ny + nz * nz)
    if length == 0:
        return False
    if nx * x + ny * y + nz * z > 0:
        length = -length
    normal[row, column, 0] = nx / length
    normal[row, column, 1] = ny / length
    normal[row, column, 2] = nz / length
    return True


@numpy_helper
def _point(camera, depth, row, column):
    fx, fy, cx, cy = camera
    z = depth[row, column]
    return (column + 0.5 - cx) / fx * z, (row + 0.5 - cy) / fy * z, z


@numpy_helper
def _step(ahead, behind, x, y, z):
    """The vector between opposite neighbours, and whether it is straight."""
    sx, sy, sz = (
        ahead[0] - behind[0],
        ahead[1] - behind[1],
        ahead[2] - behind[2],
    )
    bx = ahead[0] + behind[0] - 2 * x
    by = ahead[1] + behind[1] - 2 * y
    bz = ahead[2] + behind[2] - 2 * z
    bend = np.sqrt(bx * bx + by * by + bz * bz)
    length = np.sqrt(sx * sx + sy * sy + sz * sz)
    return sx, sy, sz, bend < MAX_BEND * length
