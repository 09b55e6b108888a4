"""Packs splats into the records that `nearest_splat` searches (Numba).

`sphere_to_ellipsoid_reference.py` is the slow reference in NumPy.
"""

import math

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.splat.bvh import leaf_range

_INFINITE = np.float32(np.inf)


@kernel
def pack_solids(index, p_WK, quaternions, scales, uncertainty, places, rows):
    """Packs splats into rows of 12 numbers for queries.

    A row contains the numbers of the splat's file without loss: centre p_WK,
    quaternion wxyz, three standard deviations (the last is 0 for a disc), and
    the uncertainty. The last entry is the radius of a ball around the splat's
    box, for semi-axes of one standard deviation [m].

    Args:
        index: Indices of the splats to pack, shape (n,).
        p_WK: Centres of all splats, shape (N, 3) [m].
        quaternions: Orientations of all splats as quaternions wxyz, shape (N,
            4).
        scales: Standard deviations of all splats, shape (N, 2) or (N, 3) [m].
        uncertainty: Uncertainty of all splats, shape (N,) [m]; empty if they
            have none.
        places: Row of each packed splat in `rows`, shape (n,).
        rows: Output: the packed splats, shape (m, 12), single precision.
    """
    n_axes = scales.shape[1]
    for i in range(len(index)):
        k, row = index[i], rows[places[i]]
        square = 0.0
        for j in range(3):
            row[j] = p_WK[k, j]
            row[7 + j] = scales[k, j] if j < n_axes else 0.0
            square += np.float64(row[7 + j]) ** 2
        for j in range(4):
            row[3 + j] = quaternions[k, j]
        row[10] = uncertainty[k] if len(uncertainty) else 0.0
        row[11] = np.nextafter(np.float32(math.sqrt(square)), _INFINITE)


@kernel
def open_solids(packed, n_sigma, rows):
    """Unpacks splats into rows of 16 numbers, which `solid` describes.

    Args:
        packed: The splats, packed by `pack_solids`, shape (n, 12).
        n_sigma: Semi-axes in standard deviations.
        rows: Output: the unpacked splats, shape (n, 16), double precision.
    """
    for i in range(len(packed)):
        opened = solid(packed[i], n_sigma)
        for j in range(16):
            rows[i, j] = opened[j]


@helper
def solid(row, n_sigma):
    """Unpacks a splat in double precision.

    Args:
        row: A row that `pack_solids` has written.
        n_sigma: Semi-axes in standard deviations.

    Returns:
        Sixteen numbers: the centre p_WK, the columns of R_WK in descending
        order of the semi-axes, the three semi-axes (the last is 0 for a disc),
        and the uncertainty.
    """
    x, y, z = columns(row)
    e, (x, y, z) = falling(semi_axes(row, n_sigma), (x, y, z))
    p = np.float64(row[0]), np.float64(row[1]), np.float64(row[2])
    return (*p, *x, *y, *z, *e, np.float64(row[10]))


@helper
def columns(row):
    """Returns the columns of the rotation matrix R_WK of a packed splat."""
    w, x = np.float64(row[3]), np.float64(row[4])
    y, z = np.float64(row[5]), np.float64(row[6])
    # The quaternion is normalised in double precision, since its rounding to
    # single precision causes errors of 1e-7.
    s = 2.0 / (w * w + x * x + y * y + z * z)
    xs, ys, zs = s * x, s * y, s * z
    xx, yy, zz = x * xs, y * ys, z * zs
    xy, xz, yz = x * ys, x * zs, y * zs
    wx, wy, wz = w * xs, w * ys, w * zs
    return (
        (1 - (yy + zz), xy + wz, xz - wy),
        (xy - wz, 1 - (xx + zz), yz + wx),
        (xz + wy, yz - wx, 1 - (xx + yy)),
    )


@helper
def semi_axes(row, n_sigma):
    """Returns the semi-axes of a packed splat, in the order of its axes."""
    return (
        n_sigma * np.float64(row[7]),
        n_sigma * np.float64(row[8]),
        n_sigma * np.float64(row[9]),
    )


@helper
def falling(e, others):
    """Sorts semi-axes, together with their data, in descending order.

    The sort is stable.
    """
    a, b, c = e
    x, y, z = others
    if b > a:
        a, b, x, y = b, a, y, x
    if c > b:
        b, c, y, z = c, b, z, y
        if b > a:
            a, b, x, y = b, a, y, x
    return (a, b, c), (x, y, z)


@kernel
def fill_boxes(rows, solved, boxes):
    """Computes boxes that contain every possible closest point of splats.

    If the computation of the closest point converges, the closest point is on
    the splat. If a bisection ends early, the point is in the box that encloses
    the splat and is aligned with the splat's axes. Uncertainty enlarges the
    result on all sides.

    Args:
        rows: The splats, unpacked by `open_solids`, shape (n, 16).
        solved: Whether closest points are converged.
        boxes: Output: lower corner, upper corner, and height of the splat's
            centre, shape (n, 7) [m].
    """
    for i in range(len(rows)):
        _bound(rows[i], solved, boxes[i])


@helper
def _bound(row, solved, box):
    """Computes the box of one splat, and writes it to `boxes`."""
    for j in range(3):
        half = 0.0
        for axis in range(3):
            extent = abs(row[3 + 3 * axis + j] * row[12 + axis])
            half += extent * extent if solved else extent
        if solved:
            half = math.sqrt(half)
        half += row[15]
        # Rounding may make a splat's box too large, but never too small.
        half += 1e-12 * (half + abs(row[j]))
        box[j] = row[j] - half
        box[3 + j] = row[j] + half
    box[6] = row[2]


@kernel
def are_enclosed(packed, n_sigma, solved, nodes, links, first, end) -> bool:
    """Returns whether the boxes of some nodes contain everything below them.

    Args:
        packed: The splats in leaf order, packed by `pack_solids`.
        n_sigma: Semi-axes in standard deviations.
        solved: Whether closest points are converged.
        nodes: Nodes of a valid `BoundingVolumeHierarchy`.
        links: Links of the hierarchy.
        first: Index of the first node to check.
        end: Index after that of the last node to check.
    """
    box = np.empty(7)
    for i in range(first, end):
        for side in range(2):
            link = links[i, 14 + side]
            if link >= 0:
                for below in range(2):
                    _bound_child(nodes[link], below, box)
                    if not _holds(nodes[i], side, box):
                        return False
                continue
            a, b = leaf_range(link)
            for place in range(a, b):
                _bound(solid(packed[place], n_sigma), solved, box)
                if not _holds(nodes[i], side, box):
                    return False
    return True


@helper
def _bound_child(node, side, box):
    """Writes the box of one child of a node."""
    for k in range(6):
        box[k] = node[6 * side + k]
    box[6] = node[12 + side]


@helper
def _holds(node, side, box) -> bool:
    """Whether the box of one child of a node contains another box."""
    holds = node[12 + side] >= box[6]
    for k in range(3):
        holds &= node[6 * side + k] <= box[k]
        holds &= node[6 * side + 3 + k] >= box[3 + k]
    return holds
