"""Cuts a part of a mesh by a plane, where its convex hull protrudes.

The hulls of both halves lie in the hull of the whole, so a cut never increases
the error of a distance. Unlike general convex decompositions, a cut here
considers only the points to which another link comes near.
"""

from itertools import product

import numpy as np

from remosplat_drake.robot.fitting.convex_pieces import below
from remosplat_drake.robot.fitting.kernels.best_plane import best_plane
from remosplat_drake.robot.fitting.simplified import grid_cells, welded

_SHARES = np.linspace(0.0, 1.0, 13)[1:-1]
"""Positions of the candidate planes across the main axes, as fractions of the
surface's extent along the axis."""

_NORMALS = np.array([n for n in product((-1, 0, 1), repeat=3) if n > (0, 0, 0)])
_NORMALS = _NORMALS / np.linalg.norm(_NORMALS, axis=1, keepdims=True)
"""Normals of the candidate planes through a point: axes and diagonals."""

_THROUGH = 4
"""Planes are tried through this many points, those that protrude most."""

_FACES = 8
"""For each of these points, the planes of this many nearest triangles are
tried. A cut along one side of a concave pocket frees the whole pocket."""

_SAME = 4e-3
"""Edge of the cells of a grid [m]. In each cell, the point that protrudes most
is used to compare planes."""

_MOST_TRIANGLES = 1500
"""Planes are compared with at most about this many triangles of a part."""

_LEAST = 5e-4
"""A cut frees a point if it increases the point's distance from the hulls by at
least this [m]."""


def cut_in_two(
    part: np.ndarray, p: np.ndarray, off: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    """Cuts a surface so that the hulls of both halves are far from some points.

    Args:
        part: Triangles, shape (t, 3, 3) [m].
        p: Points on its hull that are not on the surface, shape (n, 3) [m].
        off: Distances of these points from the surface, shape (n,) [m]; they
            must exceed half a millimetre.

    Returns:
        The triangles of both halves; None if no plane increases the distance of
        any of the points from the hulls.
    """
    farthest = np.argsort(-off)
    p, off = p[farthest], off[farthest]
    one = np.sort(np.unique(grid_cells(p, _SAME), return_index=True)[1])
    p, off = p[one], off[one]
    # A sample of a fine mesh suffices to choose a plane.
    vertices, triangles = welded(part[:: -(-len(part) // _MOST_TRIANGLES)])
    ends = triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    edges = np.unique(np.sort(ends, axis=1), axis=0)
    planes = _planes(vertices[triangles], p[:_THROUGH])
    best = best_plane(vertices, edges, planes, p, off, _LEAST)
    if best < 0:
        return None
    normal, offset = planes[best, :3], planes[best, 3]
    halves = below(part, normal, offset), below(part, -normal, -offset)
    return halves if all(map(len, halves)) else None


def _planes(surface: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Returns unit normals and offsets of candidate cutting planes, (k, 4)."""
    corners = surface.reshape(-1, 3)
    main = np.linalg.eigh(np.cov(corners.T))[1].T
    along = np.vstack([np.eye(3), main])
    height = corners @ along.T
    lower, upper = height.min(axis=0), height.max(axis=0)
    offset = lower + (upper - lower) * _SHARES[:, None]
    across = np.vstack([_NORMALS, main])
    through = np.tile(across, (len(p), 1)), (p @ across.T).reshape(-1, 1)
    along = np.tile(along, (len(offset), 1)), offset.reshape(-1, 1)
    return np.vstack(
        [np.hstack(along), np.hstack(through), _sides_near(surface, p)]
    )


def _sides_near(surface: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Returns the planes of the triangles with centroids nearest to points."""
    a, b, c = surface.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    size = np.linalg.norm(normal, axis=1)
    solid = size > 0.0
    normal = normal[solid] / size[solid, None]
    middle, a = surface[solid].mean(axis=1), a[solid]
    away = np.linalg.norm(p[:, None] - middle, axis=2)
    near = np.unique(np.argsort(away, axis=1)[:, :_FACES])
    offset = (normal[near] * a[near]).sum(axis=1)
    return np.hstack([normal[near], offset[:, None]])
