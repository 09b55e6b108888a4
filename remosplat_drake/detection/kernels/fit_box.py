"""Fits one rounded box to points; see `enclosure_reference.fit`."""

import math

import numpy as np

from remosplat_drake.base.kernels import helper, kernel

_SWEEPS = 12
"""Largest number of Jacobi sweeps to diagonalise a 3 x 3 matrix."""


@helper
def rounded_volume(a, b, c, r):
    """Volume of a box of half side lengths a, b, c, enlarged by a radius."""
    faces = 8.0 * r * (a * b + b * c + c * a)
    edges = 2.0 * math.pi * r * r * (a + b + c)
    return 8.0 * a * b * c + faces + edges + 4.0 / 3.0 * math.pi * r**3


@helper
def _rotate(A, R, p, q):
    """Applies a Jacobi rotation that makes the entry (p, q) of A zero."""
    if A[p, q] == 0.0:
        return
    angle = 0.5 * math.atan2(2.0 * A[p, q], A[q, q] - A[p, p])
    c, s = math.cos(angle), math.sin(angle)
    for k in range(3):
        x, y = A[k, p], A[k, q]
        A[k, p], A[k, q] = c * x - s * y, s * x + c * y
    for k in range(3):
        x, y = A[p, k], A[q, k]
        A[p, k], A[q, k] = c * x - s * y, s * x + c * y
        x, y = R[k, p], R[k, q]
        R[k, p], R[k, q] = c * x - s * y, s * x + c * y


@helper
def _swap(A, R, p, q):
    """Exchanges two axes, so that the frame stays right-handed."""
    A[p, p], A[q, q] = A[q, q], A[p, p]
    for k in range(3):
        R[k, p], R[k, q] = R[k, q], -R[k, p]


@helper
def _main_axes(A, R):
    """Makes R the eigenvectors of A, in the order of ascending eigenvalues."""
    for p in range(3):
        for q in range(3):
            R[p, q] = 1.0 if p == q else 0.0
    for _ in range(_SWEEPS):
        off = abs(A[0, 1]) + abs(A[0, 2]) + abs(A[1, 2])
        if off <= 1e-12 * (A[0, 0] + A[1, 1] + A[2, 2]):
            break
        _rotate(A, R, 0, 1)
        _rotate(A, R, 0, 2)
        _rotate(A, R, 1, 2)
    if A[0, 0] > A[1, 1]:
        _swap(A, R, 0, 1)
    if A[1, 1] > A[2, 2]:
        _swap(A, R, 1, 2)
    if A[0, 0] > A[1, 1]:
        _swap(A, R, 0, 1)


@helper
def _spread(p_W, A):
    """Fills A with the sum of squares of points around their mean."""
    n = len(p_W)
    x, y, z = 0.0, 0.0, 0.0
    for i in range(n):
        x, y, z = x + p_W[i, 0], y + p_W[i, 1], z + p_W[i, 2]
    x, y, z = x / n, y / n, z / n
    A[:] = 0.0
    for i in range(n):
        a, b, c = p_W[i, 0] - x, p_W[i, 1] - y, p_W[i, 2] - z
        A[0, 0] += a * a
        A[0, 1] += a * b
        A[0, 2] += a * c
        A[1, 1] += b * b
        A[1, 2] += b * c
        A[2, 2] += c * c
    A[1, 0], A[2, 0], A[2, 1] = A[0, 1], A[0, 2], A[1, 2]


@kernel
def fit_box(p_W, padding):
    """Fits the smaller of a box and a capsule, along the points' main axes.

    Args:
        p_W: At least one point in W, shape (n, 3) [m].
        padding: Margin on all sides [m].

    Returns:
        Orientation R_WM, shape (3, 3); centre in W, shape (3,) [m]; half side
        lengths of the core, shape (3,) [m]; and the radius around it [m].
    """
    A, R = np.empty((3, 3)), np.empty((3, 3))
    _spread(p_W, A)
    _main_axes(A, R)
    n = len(p_W)
    p_M = np.empty((n, 3))
    middle, half = np.empty(3), np.empty(3)
    for c in range(3):
        low, high = math.inf, -math.inf
        for i in range(n):
            x = p_W[i, 0] * R[0, c] + p_W[i, 1] * R[1, c] + p_W[i, 2] * R[2, c]
            p_M[i, c] = x
            low, high = min(low, x), max(high, x)
        middle[c], half[c] = 0.5 * (low + high), 0.5 * (high - low)
    widest, length = 0.0, 0.0
    for i in range(n):
        x, y = p_M[i, 0] - middle[0], p_M[i, 1] - middle[1]
        widest = max(widest, x * x + y * y)
    for i in range(n):
        x, y = p_M[i, 0] - middle[0], p_M[i, 1] - middle[1]
        cap = math.sqrt(max(0.0, widest - x * x - y * y))
        length = max(length, abs(p_M[i, 2] - middle[2]) - cap)
    p_WM = np.empty(3)
    for r in range(3):
        p_WM[r] = (
            R[r, 0] * middle[0] + R[r, 1] * middle[1] + R[r, 2] * middle[2]
        )
    radius = math.sqrt(widest) + padding
    box = rounded_volume(half[0], half[1], half[2], padding)
    if rounded_volume(0.0, 0.0, length, radius) < box:
        half[0], half[1], half[2] = 0.0, 0.0, length
        return R, p_WM, half, radius
    return R, p_WM, half, padding
