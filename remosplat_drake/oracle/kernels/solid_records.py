"""Splats as solids, in the records that `nearest_splat` searches (numba).

`sphere_to_ellipsoid_reference.py` says the same slowly, in NumPy.
"""

import math

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.splat.bvh import leaf_range


@kernel
def fill_records(index, p_WK, quaternions, scales, uncertainty, n_sigma, rows):
    """Packs splats into rows of 16 numbers, described in `nearest_splat`.

    Args:
        index: The splats to pack, shape (n,).
        p_WK: Centres of all splats, shape (N, 3) [m].
        quaternions: Their orientations wxyz, shape (N, 4).
        scales: Their standard deviations, shape (N, 2) or (N, 3) [m].
        uncertainty: Their uncertainty, shape (N,) [m]; empty for none.
        n_sigma: Semi-axes in standard deviations.
        rows: Filled in, shape (n, 16).
    """
    n_axes = scales.shape[1]
    for i in range(len(index)):
        k = index[i]
        for j in range(3):
            rows[i, j] = p_WK[k, j]
        a = n_sigma * np.float64(scales[k, 0])
        b = n_sigma * np.float64(scales[k, 1])
        c = n_sigma * np.float64(scales[k, 2]) if n_axes == 3 else 0.0
        # Falling semi-axes, of equal ones the first before the second.
        first = 0 if a >= b and a >= c else (1 if b >= c else 2)
        last = 2 if c <= a and c <= b else (1 if b <= a else 0)
        middle = 3 - first - last
        x, y, z = _columns(quaternions[k])
        _axis(rows[i], 0, first, x, y, z, a, b, c)
        _axis(rows[i], 1, middle, x, y, z, a, b, c)
        _axis(rows[i], 2, last, x, y, z, a, b, c)
        rows[i, 15] = uncertainty[k] if len(uncertainty) else 0.0


@helper
def _axis(row, place, which, x, y, z, a, b, c):
    """Writes axis `which` and its length as the one in this place."""
    if which == 0:
        axis, length = x, a
    elif which == 1:
        axis, length = y, b
    else:
        axis, length = z, c
    row[3 + 3 * place] = axis[0]
    row[4 + 3 * place] = axis[1]
    row[5 + 3 * place] = axis[2]
    row[12 + place] = length


@helper
def _columns(wxyz):
    """The columns of a quaternion's rotation matrix."""
    w, x = np.float64(wxyz[0]), np.float64(wxyz[1])
    y, z = np.float64(wxyz[2]), np.float64(wxyz[3])
    # Unit quaternions of floats are off by 1e-7; rotations should not be.
    length = math.sqrt(w * w + x * x + y * y + z * z)
    w, x, y, z = w / length, x / length, y / length, z / length
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)),
        (2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)),
        (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)),
    )


@kernel
def scatter_rows(rows, places, others):
    """Writes rows of 16 numbers to other places.

    Args:
        rows: Shape (n, 16).
        places: Row of `others` for each, shape (n,).
        others: Filled in at these places, shape (N, 16).
    """
    for i in range(len(rows)):
        for j in range(16):
            others[places[i], j] = rows[i, j]


@kernel
def fill_boxes(rows, solved, boxes):
    """Bounds every possible answer of a splat.

    A converged closest point is on the splat; one from a truncated bisection
    is somewhere in the box around it that is aligned to its axes. Uncertainty
    reaches beyond it to all sides.

    Args:
        rows: The splats, as `fill_records` fills them, shape (n, 16).
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
        # Rounding: a splat's box may be too large, never too small.
        half += 1e-12 * (half + abs(row[j]))
        box[j] = row[j] - half
        box[3 + j] = row[j] + half
    box[6] = row[2]


@kernel
def are_enclosed(rows, solved, nodes, links, first, end) -> bool:
    """Returns whether some nodes of a hierarchy hold what is below them.

    Args:
        rows: The splats, as `fill_records` fills them, in leaf order.
        solved: Whether closest points are converged.
        nodes: Nodes of a sound `BoundingVolumeHierarchy`.
        links: Its links.
        first: The first node to look at.
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
                _bound(rows[place], solved, box)
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
    """Whether the box of one child of a node holds another one."""
    holds = node[12 + side] >= box[6]
    for k in range(3):
        holds &= node[6 * side + k] <= box[k]
        holds &= node[6 * side + 3 + k] >= box[3 + k]
    return holds
