"""Distances of placed convex shapes: coarse bounds first, then GJK.

Kernels take the s shapes as packed `ShapeArrays`, and the poses X_WL of all
bodies, shape (b, 4, 4).
"""

import math

import numpy as np

from remosplat_drake.base.kernels import helper
from remosplat_drake.robot.self_collision.kernels.gjk import hull_distance


@helper
def centers_in_world(shapes, X_WL):
    """Places the centres of all shapes in W, shape (s, 3) [m]."""
    p_WC = np.empty((len(shapes.body), 3))
    place_centers(shapes, X_WL, p_WC)
    return p_WC


@helper
def place_centers(shapes, X_WL, p_WC):
    """Fills in the centres of all shapes in W, shape (s, 3) [m]."""
    center, body = shapes.center, shapes.body
    for i in range(len(body)):
        X = X_WL[body[i]]
        for r in range(3):
            p_WC[i, r] = X[r, 3]
            for c in range(3):
                p_WC[i, r] += X[r, c] * center[i, c]


@helper
def least_distance(shapes, X_WL, p_WC, i, j):
    """Computes a fast lower bound on the distance of two shapes.

    Each shape is enclosed by a ball around its centre and by a box along its
    link's axes. The bound is the distance from the centre of one to the box of
    the other, minus the ball's radius. It also holds for negative distances.

    Args:
        shapes: The shapes.
        X_WL: Poses of all bodies.
        p_WC: Centres of the shapes in W, shape (s, 3) [m].
        i: One shape.
        j: The other.

    Returns:
        The bound, which is negative where balls overlap [m].
    """
    radius, half = shapes.radius, shapes.half
    reach, body = shapes.reach, shapes.body
    x = p_WC[j, 0] - p_WC[i, 0]
    y = p_WC[j, 1] - p_WC[i, 1]
    z = p_WC[j, 2] - p_WC[i, 2]
    best = math.sqrt(x * x + y * y + z * z) - reach[i] - reach[j]
    if best < reach[i] + reach[j]:
        from_i = _to_box(X_WL, body[i], half, i, x, y, z) - reach[j]
        from_j = _to_box(X_WL, body[j], half, j, x, y, z) - reach[i]
        best = max(best, from_i, from_j)
    return best - radius[i] - radius[j]


@helper
def _to_box(X_WL, body, half, i, x, y, z):
    """Signed distance from a box, whose axes are its link's, to a point [m].

    x, y, z is the vector from the centre of the box to the point; its sign does
    not matter.
    """
    square, inside = 0.0, -math.inf
    for c in range(3):
        along = X_WL[body, 0, c] * x + X_WL[body, 1, c] * y
        along = abs(along + X_WL[body, 2, c] * z) - half[i, c]
        inside = max(inside, along)
        if along > 0.0:
            square += along * along
    return math.sqrt(square) if square > 0.0 else inside


@helper
def shape_distance(shapes, X_WA, X_WB, pair, guess_W, enough, work):
    """Computes the signed distance of two placed shapes.

    Args:
        shapes: The shapes.
        X_WA: Pose of the first one's link, shape (4, 4).
        X_WB: Pose of the second one's link, shape (4, 4).
        pair: The first shape and the second.
        guess_W: Initial vector in W from the first to the second, shape (3,).
        enough: If the distance proves to exceed this value, a lower bound is
            returned [m].
        work: Arrays of `gjk.make_work`; the last is filled with the nearest
            points in the first link's frame A. Points of rounded shapes lie a
            radius inside the shape.

    Returns:
        The distance [m], and the unit vector from the first to the second in
        A along which it is measured, as three numbers.
    """
    first, radius = shapes.first, shapes.radius
    i, j = pair
    R_AB, p_AB, guess = np.empty((3, 3)), np.empty(3), np.empty(3)
    for r in range(3):
        guess[r] = p_AB[r] = 0.0
        for k in range(3):
            guess[r] += X_WA[k, r] * guess_W[k]
            p_AB[r] += X_WA[k, r] * (X_WB[k, 3] - X_WA[k, 3])
        for c in range(3):
            R_AB[r, c] = 0.0
            for k in range(3):
                R_AB[r, c] += X_WA[k, r] * X_WB[k, c]
    a = first[i], first[i + 1]
    b = first[j], first[j + 1]
    radii = radius[i] + radius[j]
    distance, x, y, z = hull_distance(
        (shapes.blocks, a, b, R_AB, p_AB),
        (guess[0], guess[1], guess[2]),
        enough + radii,
        work,
    )
    return distance - radii, x, y, z


@helper
def distance_beyond(shapes, X_WL, p_WC, pair, enough, work):
    """Computes the signed distance of two shapes, after a coarse bound.

    Args:
        shapes: The shapes.
        X_WL: Poses of all bodies.
        p_WC: Centres of the shapes in W, shape (s, 3) [m].
        pair: The first shape and the second.
        enough: Above this value, a lower bound suffices [m].
        work: Arrays of `gjk.make_work`.
    """
    i, j = pair
    found = least_distance(shapes, X_WL, p_WC, i, j)
    if found >= enough:
        return found
    body = shapes.body
    guess_W = np.empty(3)
    for k in range(3):
        guess_W[k] = p_WC[j, k] - p_WC[i, k]
    found, _, _, _ = shape_distance(
        shapes, X_WL[body[i]], X_WL[body[j]], pair, guess_W, enough, work
    )
    return found
