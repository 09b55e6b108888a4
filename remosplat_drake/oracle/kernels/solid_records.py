"""Splats as solids, in the records that `nearest_splat` searches (numba).

`sphere_to_ellipsoid_reference.py` says the same slowly, in NumPy.
"""

import math

import numpy as np

from remosplat_drake.base.kernels import helper, kernel


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
def fill_boxes(rows, solved, boxes):
    """Bounds every possible answer of a splat.

    A converged closest point is on the splat; one from a truncated bisection
    is somewhere in the box around it that is aligned to its axes. Uncertainty
    reaches beyond it to all sides.

    Args:
        rows: The splats, as `fill_records` fills them, shape (n, 16).
        solved: Whether closest points are converged.
        boxes: Filled in, shape (n, 8): lower corner, upper corner, height of
            the centre [m], place.
    """
    for i in range(len(rows)):
        for j in range(3):
            half = 0.0
            for axis in range(3):
                extent = abs(rows[i, 3 + 3 * axis + j] * rows[i, 12 + axis])
                half += extent * extent if solved else extent
            if solved:
                half = math.sqrt(half)
            half += rows[i, 15]
            # Rounding: a splat's box may be too large, never too small.
            half += 1e-12 * (half + abs(rows[i, j]))
            boxes[i, j] = rows[i, j] - half
            boxes[i, 3 + j] = rows[i, j] + half
        boxes[i, 6] = rows[i, 2]
        boxes[i, 7] = i
