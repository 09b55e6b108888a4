"""Splats as solids, in the records that `nearest_splat` searches (Numba).

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

    A row holds the data of the splat's file without loss: centre p_WK,
    quaternion wxyz, three standard deviations (the last 0 for a disc) and the
    uncertainty. Last comes the radius of a ball around all of the splat's box,
    in standard deviations.

    Args:
        index: The splats to pack, shape (n,).
        p_WK: Centres of all splats, shape (N, 3) [m].
        quaternions: Their orientations wxyz, shape (N, 4).
        scales: Their standard deviations, shape (N, 2) or (N, 3) [m].
        uncertainty: Their uncertainty, shape (N,) [m]; empty for none.
        places: Index in `rows` of each packed splat, shape (n,).
        rows: Filled in at these places, shape (m, 12), single precision.
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
    """Unpacks splats into rows of 16 numbers, described in `solid`.

    Args:
        packed: The splats, as `pack_solids` packs them, shape (n, 12).
        n_sigma: Semi-axes in standard deviations.
        rows: Filled in, shape (n, 16), double precision.
    """
    for i in range(len(packed)):
        opened = solid(packed[i], n_sigma)
        for j in range(16):
            rows[i, j] = opened[j]


@helper
def solid(row, n_sigma):
    """Unpacks a splat in double precision.

    Args:
        row: A row of `pack_solids`.
        n_sigma: Semi-axes in standard deviations.

    Returns:
        Sixteen numbers: centre p_WK, the columns of R_WK sorted by descending
        semi-axis, the three semi-axes (the last 0 for a disc) and the
        uncertainty.
    """
    x, y, z = columns(row)
    e, (x, y, z) = falling(semi_axes(row, n_sigma), (x, y, z))
    p = np.float64(row[0]), np.float64(row[1]), np.float64(row[2])
    return (*p, *x, *y, *z, *e, np.float64(row[10]))


@helper
def columns(row):
    """The columns of the rotation matrix R_WK of a packed splat."""
    w, x = np.float64(row[3]), np.float64(row[4])
    y, z = np.float64(row[5]), np.float64(row[6])
    # Unit quaternions of floats have errors of 1e-7; rotations must not.
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
    """The semi-axes of a packed splat, in the order of its own axes."""
    return (
        n_sigma * np.float64(row[7]),
        n_sigma * np.float64(row[8]),
        n_sigma * np.float64(row[9]),
    )


@helper
def falling(e, others):
    """Sorts semi-axes in descending order, together with their data.

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

    A converged closest point is on the splat. One from a bisection that ends
    early is in the box around the splat that is aligned with the splat's axes.
    Uncertainty enlarges the bound on all sides.

    Args:
        rows: The splats, as `open_solids` writes them, shape (n, 16).
        solved: Whether closest points are converged.
        boxes: Filled in, shape (n, 7): lower corner, upper corner, height of
            the centre [m].
    """
    for i in range(len(rows)):
        _bound(rows[i], solved, boxes[i])


@helper
def _bound(row, solved, box):
    """Writes the box of one splat."""
    for j in range(3):
        half = 0.0
        for axis in range(3):
            extent = abs(row[3 + 3 * axis + j] * row[12 + axis])
            half += extent * extent if solved else extent
        if solved:
            half = math.sqrt(half)
        half += row[15]
        # Rounding may make a splat's box too large, never too small.
        half += 1e-12 * (half + abs(row[j]))
        box[j] = row[j] - half
        box[3 + j] = row[j] + half
    box[6] = row[2]


@kernel
def are_enclosed(packed, n_sigma, solved, nodes, links, first, end) -> bool:
    """Returns whether the boxes of some nodes contain everything below them.

    Args:
        packed: The splats in leaf order, as `pack_solids` packs them.
        n_sigma: Semi-axes in standard deviations.
        solved: Whether closest points are converged.
        nodes: Nodes of a valid `BoundingVolumeHierarchy`.
        links: Its links.
        first: The first node to check.
        end: The one after the last.
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
