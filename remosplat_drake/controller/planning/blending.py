"""Rounds off the corners of a path, as far as the space there is free.

The robot must pass a corner slowly, since its velocity changes instantly there.
A blend is a parabola from a point before the corner to a point at the same
distance after it, with the corner as its control point (Kunz and Stilman 2012
use circles).
"""

import math
from itertools import pairwise

import numpy as np

from remosplat_drake.controller.planning.free_space import FreeSpace

_TURN = 0.15
"""Largest turn between two pieces of a blend [rad]."""

_TRIES = 4
"""Number of times that a blend is halved if it is not collision-free."""


def blended_corners(
    space: FreeSpace, corners: np.ndarray, longest: float
) -> np.ndarray:
    """Replaces the corners of a path by collision-free blends.

    A differential base must stop between turning and driving, so its paths keep
    the corners between the two.

    Args:
        space: The free space.
        corners: Corners of a free path, no two neighbours equal, shape
            (k, n_q) [rad, m].
        longest: Largest distance from a corner to the ends of its blend, in
            radians and metres alike.

    Returns:
        Corners of the blended path, shape (m, n_q) [rad, m].
    """
    if space.robot.n_base == 2:
        return corners
    reach = 0.5 * np.linalg.norm(np.diff(corners, axis=0), axis=1)
    kept = [corners[0]]
    for k in range(1, len(corners) - 1):
        before, corner, after = corners[k - 1 : k + 2]
        most = min(reach[k - 1], reach[k], longest)
        kept.extend(_blend(space, before, corner, after, most))
    return np.array([*kept, corners[-1]])


def _blend(
    space: FreeSpace,
    before: np.ndarray,
    corner: np.ndarray,
    after: np.ndarray,
    most: float,
) -> np.ndarray:
    """Returns the points of the longest free blend, or the corner alone."""
    start, end = before - corner, after - corner
    start, end = start / np.linalg.norm(start), end / np.linalg.norm(end)
    turn = math.acos(float(np.clip(-start @ end, -1.0, 1.0)))
    pieces = math.ceil(turn / _TURN) + 1
    share = np.linspace(0.0, 1.0, pieces + 1)[:, None]
    for reach in most * 0.5 ** np.arange(_TRIES):
        # Relative to the corner, the parabola's control points are start, 0 and
        # end.
        off = (1.0 - share) ** 2 * start + share**2 * end
        points = corner + reach * off
        if _is_free(space, points):
            return points
    return corner[None]


def _is_free(space: FreeSpace, points: np.ndarray) -> bool:
    """Whether a blend is free; its first point, on the path, always is."""
    return all(space.is_free_between(a, b) for a, b in pairwise(points))
