"""`find_level_surface`: finds a level surface in points of a map."""

import math

import numpy as np
import scipy
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.scene.primitive_scene import Box

TILT = math.radians(1.0)
"""Largest angle between a level surface and the horizontal plane [rad]."""

SMALLEST = 0.06
"""Objects are placed on a surface only if its sides are at least this long [m].
"""

THICKNESS = 0.02
"""Thickness of the box that represents a surface [m]."""

_NEAR = 0.1
"""Largest distance between the given point and the surface [m]."""

_PATCH = 0.08
"""The search begins with a patch of this radius around the given point [m]."""

_BAND = 0.008
"""A point belongs to a surface only if it is at most this far from its plane
[m]."""

_ALIKE = math.cos(math.radians(25.0))
"""A point belongs to a surface only if the cosine of the angle between their
normals is at least this."""

_CELL = 0.02
"""Side of the cells that a surface's points must fill [m]."""

_FITS, _LEAST = 4, 8
"""The plane is fitted this many times (first number), each time to at least
this many points (second number)."""


def find_level_surface(
    points: np.ndarray,
    normals: np.ndarray,
    near: np.ndarray,
    reach: float,
    name: str = "",
) -> Box:
    """Finds the largest level rectangle of map points around a point.

    The function fits a plane to the points around the given point. The points
    near the plane fill cells of a grid. The result is the largest rectangle
    that contains the given point and only filled cells.

    Args:
        points: Points of surfaces in W, shape (n, 3) [m].
        normals: Normals at these points, of either sign, shape (n, 3).
        near: A point at the surface, shape (3,) [m].
        reach: Largest horizontal distance of the rectangle from `near` along x
            and along y [m].
        name: Name of the box.

    Returns:
        A box of the thickness `THICKNESS` with this rectangle as its top.

    Raises:
        RemoSplatError: There is no surface at the point, or it is tilted or
            too small.
    """
    box = np.abs(points - near) <= [reach, reach, _NEAR]
    inside = box.all(axis=1)
    points, normals = points[inside], normals[inside]
    away = np.linalg.norm(points - near, axis=1)
    if not (away <= _NEAR).any():
        raise RemoSplatError(
            f"the map has no surface within {_NEAR:g} m of this point"
        )
    normal, p_W = _plane(points, normals, points[away.argmin()])
    tilt = math.acos(min(abs(float(normal[2])), 1.0))
    if tilt > TILT:
        raise RemoSplatError(
            f"the surface there is tilted by {math.degrees(tilt):.0f} deg, so "
            "no object can stand on it"
        )
    on_it = np.abs((points - p_W) @ normal) < _BAND
    on_it &= np.abs(normals @ normal) > _ALIKE
    middle, sides = _rectangle(points[on_it, :2], np.asarray(near)[:2])
    if sides.min() < SMALLEST:
        width, depth = 1e3 * sides
        raise RemoSplatError(
            f"the surface there is too small: {width:.0f} mm x {depth:.0f} mm"
        )
    height = p_W[2] - normal[:2] @ (middle - p_W[:2]) / normal[2]
    X_WP = RigidTransform(RotationMatrix(), [*middle, height - 0.5 * THICKNESS])
    return Box(X_WP, 0.5 * np.array([*sides, THICKNESS]), name)


def _plane(
    points: np.ndarray, normals: np.ndarray, p_W: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Fits a plane to points around one of them: its normal and a point."""
    nearest = np.linalg.norm(points - p_W, axis=1).argmin()
    normal = normals[nearest]
    close = np.linalg.norm(points - p_W, axis=1) <= _PATCH
    for _ in range(_FITS):
        used = close & (np.abs(normals @ normal) > _ALIKE)
        used &= np.abs((points - p_W) @ normal) < _BAND
        if np.count_nonzero(used) < _LEAST:
            raise RemoSplatError("the map shows too little of a surface there")
        p_W = points[used].mean(axis=0)
        normal = np.linalg.svd(points[used] - p_W)[2][2]
    return normal, p_W


def _rectangle(
    points: np.ndarray, near: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The largest rectangle of filled cells around a point.

    Args:
        points: Points in the plane, shape (n, 2) [m].
        near: The point, shape (2,) [m].

    Returns:
        Its middle and its side lengths, along x and y, shape (2,) each [m].
    """
    cells = np.floor((points - near) / _CELL + 0.5).astype(int)
    lower = np.minimum(cells.min(axis=0), 0) - 1
    size = np.maximum(cells.max(axis=0), 0) - lower + 2
    filled = np.zeros(size, bool)
    filled[tuple((cells - lower).T)] = True
    # Gaussians are larger than the gaps between their centres.
    filled = scipy.ndimage.binary_closing(filled, np.ones((3, 3)))
    seed_x, seed_y = -lower
    best, most = (seed_x, seed_x, seed_y, seed_y), 0
    for first in range(seed_x, -1, -1):
        column = filled[first : seed_x + 1].all(axis=0)
        for last in range(seed_x, len(filled)):
            column = column & filled[last]
            if not column[seed_y]:
                break
            gaps = np.flatnonzero(~column)
            begin = gaps[gaps < seed_y].max(initial=-1) + 1
            end = gaps[gaps > seed_y].min(initial=len(column)) - 1
            area = (last - first + 1) * (end - begin + 1)
            if area > most:
                best, most = (first, last, begin, end), area
    if not most:
        return near, np.zeros(2)
    first = lower + np.array([best[0], best[2]])
    last = lower + np.array([best[1], best[3]])
    # The rectangle ends at the centres of its outer cells, since outer cells
    # may be only half filled.
    return near + 0.5 * _CELL * (first + last), _CELL * (last - first)
