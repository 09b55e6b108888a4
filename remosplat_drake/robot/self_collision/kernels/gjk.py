"""Distance of two convex hulls (Gilbert, Johnson and Keerthi, 1988).

The Minkowski difference of two hulls A and B is the set of all b - a. Its point
nearest to the origin is the vector from the nearest point of A to that of B.
GJK approaches this point over simplices of vertices.

The result is a valid lower bound despite rounding in the simplex: for a unit
vector n, the distance is at least the least n'(b - a) over the vertices. The
best such bound is returned as the distance, and n separates the hulls.

For overlapping hulls, `epa` computes the negative distance.
`hull_distance_reference.py` contains two slow references.
"""

import math

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import REAL, several
from remosplat_drake.robot.self_collision.kernels.epa import penetration
from remosplat_drake.robot.self_collision.kernels.simplex import (
    nearest_on_simplex,
)
from remosplat_drake.robot.self_collision.kernels.support import add_support

_STEPS = 60
"""Number of steps after which the result is only a lower bound."""

_EXACT = 1e-12
"""Difference of two bounds on a distance that count as equal [m]."""


@helper
def make_work():
    """Makes the working arrays of `hull_distance`, which can be reused."""
    return np.zeros((3, 4, 3)), np.zeros(4), np.zeros(3), np.zeros((2, 3))


@kernel(returns=several(REAL, REAL, REAL, REAL))
def hull_distance(hulls, guess, enough, work):
    """Computes the signed distance of two hulls, negative where they overlap.

    Args:
        hulls: Hulls A and B: the vertices of all hulls, each in its own frame,
            in `vertex_blocks`, shape (v, 3, 8) [m]; the first block of A and
            the one after its last; the same of B; orientation and origin of
            B's frame in A's, shape (3, 3) and (3,) [m].
        guess: Initial vector from A to B in A's frame; the closer to the
            direction of the distance, the fewer steps are needed.
        enough: If the distance proves to exceed this value, a lower bound is
            returned, without points [m].
        work: Arrays of `make_work`; the last, shape (2, 3), receives a point of
            A and one of B in A's frame: the nearest, or if the hulls overlap
            the deepest.

    Returns:
        The distance [m], and the unit vector from A to B in A's frame along
        which it is measured, as three numbers.
    """
    simplex, weights, v, nearest = work
    v[0], v[1], v[2] = guess
    size, last = 0, np.inf
    best, x, y, z = -np.inf, 0.0, 0.0, 1.0
    for _ in range(_STEPS):
        norm = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
        if size and (norm < _EXACT or norm >= last):
            break
        if norm < _EXACT:
            v[0], v[1], v[2], norm = 0.0, 0.0, 1.0, 1.0
        nx, ny, nz = v[0] / norm, v[1] / norm, v[2] / norm
        bound = add_support(hulls, nx, ny, nz, simplex, size)
        if bound > best:
            best, x, y, z = bound, nx, ny, nz
        if best > enough:
            return best, x, y, z
        if size and (norm - best <= _EXACT or _is_known(simplex[0], size)):
            break
        last = norm if size else np.inf
        size = nearest_on_simplex(simplex, size + 1, weights, v)
        if size == 4:
            break
    if size == 4 or best < -_EXACT:
        return penetration(hulls, simplex, size, (best, x, y, z), nearest)
    for k in range(3):
        nearest[0, k] = nearest[1, k] = 0.0
        for i in range(size):
            nearest[0, k] += weights[i] * simplex[1, i, k]
            nearest[1, k] += weights[i] * simplex[2, i, k]
    return best, x, y, z


@helper
def _is_known(points, row):
    """Returns whether a point equals one of the points before it."""
    for i in range(row):
        if (
            points[i, 0] == points[row, 0]
            and points[i, 1] == points[row, 1]
            and points[i, 2] == points[row, 2]
        ):
            return True
    return False
