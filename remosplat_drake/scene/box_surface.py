"""Spreads points evenly over the faces of a box."""

import numpy as np


def box_surface(
    half_extents: np.ndarray, spacing: float
) -> tuple[np.ndarray, np.ndarray]:
    """Places points on the faces of a box.

    Args:
        half_extents: Half side lengths along the box's axes, shape (3,) [m].
        spacing: Greatest distance of neighbouring points on a face [m].

    Returns:
        The points in the box's frame, shape (n, 3) [m], and the outward unit
        normals there, shape (n, 3).
    """
    points, normals = [], []
    for axis in range(3):
        a, b = (axis + 1) % 3, (axis + 2) % 3
        u, v = np.meshgrid(
            cell_centers(half_extents[a], spacing),
            cell_centers(half_extents[b], spacing),
        )
        for side in (-1.0, 1.0):
            face = np.zeros((u.size, 3))
            face[:, a], face[:, b] = u.ravel(), v.ravel()
            face[:, axis] = side * half_extents[axis]
            points.append(face)
            normals.append(np.tile(side * np.eye(3)[axis], (u.size, 1)))
    return np.concatenate(points), np.concatenate(normals)


def cell_centers(half: float, spacing: float) -> np.ndarray:
    """Returns the centres of equal cells that divide an interval, shape (n,).

    Args:
        half: Half the interval's length; its middle is zero [m].
        spacing: Greatest length of a cell [m].
    """
    n = max(int(np.ceil(2 * half / spacing)), 1)
    return half * (2 * np.arange(n) + 1 - n) / n
