"""Operations on 3D vectors for kernels; a vector is an array or a tuple.

Kernels use these functions instead of NumPy's, which allocate an array in each
operation and take longer to compile.
"""

import math

import numpy as np

from remosplat_drake.base.kernels import helper


@helper
def dot(a, b):
    """Computes the dot product of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@helper
def cross(a, b):
    """Computes the cross product of two vectors, as three numbers."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@helper
def norm(a):
    """Computes the length of a vector."""
    return math.sqrt(dot(a, a))


@helper
def set_vector(out, a) -> None:
    """Writes a vector into an array.

    Args:
        out: The array, shape (3,).
        a: The vector.
    """
    out[0], out[1], out[2] = a[0], a[1], a[2]


@helper
def across(n, angle):
    """Returns two perpendicular unit vectors that are perpendicular to a third.

    Args:
        n: The third vector, a unit vector, shape (3,).
        angle: Angle by which the two vectors are rotated about n [rad].

    Returns:
        The two vectors, shape (2, 3).
    """
    least = 0
    for c in range(3):
        if abs(n[c]) < abs(n[least]):
            least = c
    axes = np.zeros((2, 3))
    axes[0, least] = 1.0
    along = n[least]
    norm = math.sqrt(1.0 - along * along)
    for c in range(3):
        axes[0, c] = (axes[0, c] - along * n[c]) / norm
    axes[1, 0] = n[1] * axes[0, 2] - n[2] * axes[0, 1]
    axes[1, 1] = n[2] * axes[0, 0] - n[0] * axes[0, 2]
    axes[1, 2] = n[0] * axes[0, 1] - n[1] * axes[0, 0]
    s, c = math.sin(angle), math.cos(angle)
    for k in range(3):
        v, w = axes[0, k], axes[1, k]
        axes[0, k], axes[1, k] = c * v + s * w, c * w - s * v
    return axes


@helper
def rotation(axis, angle):
    """Returns the matrix of a rotation about a unit vector, shape (3, 3)."""
    s, c = math.sin(angle), math.cos(angle)
    x, y, z = axis[0], axis[1], axis[2]
    R = np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            R[i, j] = axis[i] * axis[j] * (1.0 - c)
        R[i, i] += c
    R[0, 1] -= z * s
    R[1, 0] += z * s
    R[0, 2] += y * s
    R[2, 0] -= y * s
    R[1, 2] -= x * s
    R[2, 1] += x * s
    return R
