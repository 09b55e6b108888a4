"""Cutting a part of a mesh by a plane, where its convex hull stands out.

The hulls of both halves lie in the hull of the whole, so that a cut never
makes distances worse. CoACD looks at all of a mesh; here it is known where
another link comes near.
"""

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from remosplat_drake.robot.fitting.convex_pieces import below

_OFFSETS = np.linspace(0.0, 1.0, 13)[1:-1]
"""Where planes are tried, as a share of the extent along their normals."""

_MOST_TRIANGLES = 1500
"""Triangles of a part by which planes are compared."""

_LEAST = 5e-4
"""How far halves are from the points that are to be freed, at the least [m]: as
far as pieces stand out anyway."""


def cut_in_two(
    part: np.ndarray, p: np.ndarray, off: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    """Cuts a part of a surface by the plane that frees some points most.

    Args:
        part: Triangles, shape (t, 3, 3) [m].
        p: Points on its hull that are not on the surface, shape (n, 3) [m].
        off: Their distances from the surface, shape (n,) [m].

    Returns:
        The triangles of both halves; None if no plane frees any of the points.
    """
    # All of a fine mesh is not needed to choose a plane.
    some = part[:: -(-len(part) // _MOST_TRIANGLES)]
    corners = some.reshape(-1, 3)
    normals = np.vstack([np.eye(3), np.linalg.eigh(np.cov(corners.T))[1].T])
    best, plane = 0.0, None
    for normal in normals:
        height = corners @ normal
        lowest, highest = height.min(), height.max()
        for offset in lowest + (highest - lowest) * _OFFSETS:
            free = _freed(some, height.reshape(-1, 3) - offset, p)
            gain = float((np.minimum(free, off) * off).sum())
            if free.max() > _LEAST and gain > best:
                best, plane = gain, (normal, offset)
    if plane is None:
        return None
    normal, offset = plane
    return below(part, normal, offset), below(part, -normal, -offset)


def _freed(part: np.ndarray, height: np.ndarray, p: np.ndarray) -> np.ndarray:
    """How far points are from the hulls of both halves of a part, (n,) [m].

    Args:
        part: Triangles, shape (t, 3, 3) [m].
        height: Heights of their corners above a plane, shape (t, 3) [m].
        p: The points, shape (n, 3) [m].
    """
    ends = np.roll(part, -1, axis=1), np.roll(height, -1, axis=1)
    crossing = height * ends[1] < 0
    a, b = part[crossing], ends[0][crossing]
    h_a, h_b = height[crossing], ends[1][crossing]
    on_plane = a + (b - a) * (h_a / (h_a - h_b))[:, None]
    halves = [
        np.vstack([part[side * height >= 0], on_plane]) for side in (-1, 1)
    ]
    try:
        hulls = [ConvexHull(half) for half in halves]
    except (QhullError, ValueError):
        return np.zeros(len(p))
    return np.min(
        [
            (p @ hull.equations[:, :3].T + hull.equations[:, 3]).max(axis=1)
            for hull in hulls
        ],
        axis=0,
    )
