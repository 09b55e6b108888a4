"""Computes the distance of a point from an ellipsoid or a flat elliptic disc.

All vectors are expressed in the frame of the ellipsoid, whose axes are its
principal axes. For a point y, the closest point x on the surface of an
ellipsoid with semi-axes e satisfies x_i = e_i^2 y_i / (T + e_i^2). Here T is
the only root for which x is on the surface (Eberly, "Distance from a Point to
an Ellipse, an Ellipsoid, or a Hyperellipsoid", the paper's reference). All
quantities are scaled by the smallest semi-axis e_2: t = T / e_2^2 + 1, n_i =
(e_i / e_2)^2 |y_i| / e_i and d_i = (e_i / e_2)^2 - 1. Then the root t of

    |p(t)| = 1,  p_i(t) = n_i / (t + d_i),  x_i = e_i p_i

is well conditioned, even if the ellipsoid is flat, thin or far away. Semi-axes
are sorted, e_0 >= e_1 >= e_2. A disc has e_2 = 0, and its normal is axis 2.
`sphere_to_ellipsoid_reference.py` is the slow reference in NumPy.
"""

import math

import numpy as np

from remosplat_drake.base.kernels import helper

CONVERGE = -1
"""Value of `steps` that selects Newton's method to double precision, in place
of bisection."""


@helper
def box_distance_squared(y, e) -> float:
    """Returns the squared distance from y to the ellipsoid's box [-e, e]."""
    a = max(abs(y[0]) - e[0], 0.0)
    b = max(abs(y[1]) - e[1], 0.0)
    c = max(abs(y[2]) - e[2], 0.0)
    return a * a + b * b + c * c


@helper
def is_inside(y, e) -> bool:
    """Returns whether y is inside the ellipsoid with semi-axes e, e_2 > 0."""
    z0 = y[0] / e[0]
    z1 = y[1] / e[1]
    z2 = y[2] / e[2]
    return z0 * z0 + z1 * z1 + z2 * z2 < 1.0


@helper
def closest_on_disc(y, e, steps):
    """Returns the point of a filled disc that is closest to y.

    Args:
        y: The point in the disc's frame [m].
        e: Semi-axes e_0 and e_1 of the disc; e_2 is not used [m].
        steps: Number of bisection steps, or CONVERGE.

    Returns:
        The distance, which is never negative, and the closest point [m].
    """
    z0 = abs(y[0]) / e[0]
    z1 = abs(y[1]) / e[1]
    if z0 * z0 + z1 * z1 <= 1.0:
        return abs(y[2]), (y[0], y[1], 0.0)
    r = (e[0] / e[1]) ** 2
    p0, _, p1 = _unit_point(r * z0, 0.0, z1, r - 1.0, 0.0, False, steps)
    x0 = math.copysign(e[0] * p0, y[0])
    x1 = math.copysign(e[1] * p1, y[1])
    a = y[0] - x0
    b = y[1] - x1
    return math.sqrt(a * a + b * b + y[2] * y[2]), (x0, x1, 0.0)


@helper
def closest_on_ellipsoid(y, e, steps):
    """Returns the point on an ellipsoid's surface that is closest to y.

    Args:
        y: The point in the ellipsoid's frame [m].
        e: Semi-axes, e_0 >= e_1 >= e_2 > 0 [m].
        steps: Number of bisection steps, or CONVERGE.

    Returns:
        The distance, which is negative inside, and the closest point [m].
    """
    z0 = abs(y[0]) / e[0]
    z1 = abs(y[1]) / e[1]
    z2 = abs(y[2]) / e[2]
    r0 = (e[0] / e[2]) ** 2
    r1 = (e[1] / e[2]) ** 2
    inside = is_inside(y, e)
    p0, p1, p2 = _unit_point(
        r0 * z0, r1 * z1, z2, r0 - 1.0, r1 - 1.0, inside, steps
    )
    x0 = math.copysign(e[0] * p0, y[0])
    x1 = math.copysign(e[1] * p1, y[1])
    x2 = math.copysign(e[2] * p2, y[2])
    a = y[0] - x0
    b = y[1] - x1
    c = y[2] - x2
    distance = math.sqrt(a * a + b * b + c * c)
    return (-distance if inside else distance), (x0, x1, x2)


@helper
def _unit_point(n0, n1, n2, d0, d1, inside, steps):
    """Returns the p of the module's equation, for d_2 = 0 and n_i >= 0.

    If y is in the plane of the two longer axes and near the centre, no t > 0
    solves the equation. Then the closest point is outside this plane.
    """
    # At t = `low`, the largest p_i is 1, so |p| >= 1.
    low = max(n2, max(n1 - d1, n0 - d0), 0.0)
    if low <= 0.0:
        p0 = n0 / d0 if n0 > 0.0 else 0.0
        p1 = n1 / d1 if n1 > 0.0 else 0.0
        rest = 1.0 - p0 * p0 - p1 * p1
        if n2 == 0.0 and rest > 0.0:
            return p0, p1, math.sqrt(rest)
        low = np.finfo(np.float64).tiny
    if steps == CONVERGE:
        t = _newton_root(n0, n1, n2, d0, d1, low)
    else:
        high = math.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
        if inside:
            high = min(high, 1.0)
        t = _bisected_root(n0, n1, n2, d0, d1, low, high, steps)
    return n0 / (t + d0), n1 / (t + d1), n2 / t


@helper
def _newton_root(n0, n1, n2, d0, d1, t) -> float:
    """Solves 1 / |p(t)| = 1 by Newton's method, from a t below the root.

    The left-hand side is concave and nearly linear in t (the secular equation
    of trust-region methods). So no step overshoots, and a few steps suffice.
    """
    for _ in range(100):
        i0 = 1.0 / (t + d0)
        i1 = 1.0 / (t + d1)
        i2 = 1.0 / t
        s0 = (n0 * i0) ** 2
        s1 = (n1 * i1) ** 2
        s2 = (n2 * i2) ** 2
        square = s0 + s1 + s2
        slope = s0 * i0 + s1 * i1 + s2 * i2
        step = (math.sqrt(square) - 1.0) * square / slope
        if not step > 0.0:
            break
        t += step
        # The error after a step is proportional to the square of the step.
        if step <= 1e-9 * t:
            break
    return t


@helper
def _bisected_root(n0, n1, n2, d0, d1, low, high, steps) -> float:
    """Returns the midpoint of the bracket after `steps` bisections."""
    t = 0.5 * (low + high)
    for _ in range(steps):
        p0 = n0 / (t + d0)
        p1 = n1 / (t + d1)
        p2 = n2 / t
        if p0 * p0 + p1 * p1 + p2 * p2 > 1.0:
            low = t
        else:
            high = t
        t = 0.5 * (low + high)
    return t
