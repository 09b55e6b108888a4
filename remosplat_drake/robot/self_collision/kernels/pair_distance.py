"""Distances of placed convex shapes: coarse bounds first, then GJK.

Kernels take the s shapes as packed `ShapeArrays`, and the poses X_WL of all
bodies, shape (b, 4, 4).
"""

import math

import numpy as np

from remosplat_drake.base.box_distance import distance_to_box
from remosplat_drake.base.kernels import helper
from remosplat_drake.base.lanes import (
    WIDTH,
    greatest,
    lanes_from,
    root,
)
from remosplat_drake.robot.pose_lanes import turned_back
from remosplat_drake.robot.self_collision.kernels.gjk import hull_distance


@helper
def centers_in_world(shapes, X_WL):
    """Places the centres of all shapes in W, shape (s, 3) [m]."""
    p_WC = np.empty((len(shapes.body), 3))
    place_centers(shapes, X_WL, p_WC)
    return p_WC


@helper
def place_centers(shapes, X_WL, p_WC):
    """Writes the centres of all shapes in W to an array (s, 3) [m]."""
    for i in range(len(shapes.body)):
        place_center(shapes, X_WL, i, p_WC)


@helper
def place_center(shapes, X_WL, i, p_WC):
    """Writes the centre of shape i in W to row i of an array (s, 3) [m]."""
    X, center = X_WL[shapes.body[i]], shapes.center[i]
    for r in range(3):
        p_WC[i, r] = X[r, 3]
        for c in range(3):
            p_WC[i, r] += X[r, c] * center[c]


@helper
def least_distance(shapes, X_WL, p_WC, i, j):
    """Computes a fast lower bound on the distance of two shapes.

    Each shape is enclosed by a ball around its centre and by a box along its
    link's axes. The bound is the distance from one shape's centre to the other
    shape's box, minus the radius of the first shape's ball. It also holds for
    negative distances.

    Args:
        shapes: The shapes.
        X_WL: Poses of all bodies.
        p_WC: Centres of the shapes in W, shape (s, 3) [m].
        i: One shape.
        j: The other.

    Returns:
        The bound, which is negative if the ball overlaps the box [m].
    """
    radius, half = shapes.radius, shapes.half
    reach, body = shapes.reach, shapes.body
    x = p_WC[j, 0] - p_WC[i, 0]
    y = p_WC[j, 1] - p_WC[i, 1]
    z = p_WC[j, 2] - p_WC[i, 2]
    best = math.sqrt(x * x + y * y + z * z) - reach[i] - reach[j]
    if best < reach[i] + reach[j]:
        from_i = _to_box(half, i, _along(X_WL[body[i]], x, y, z)) - reach[j]
        from_j = _to_box(half, j, _along(X_WL[body[j]], x, y, z)) - reach[i]
        best = max(best, from_i, from_j)
    return best - radius[i] - radius[j]


@helper
def least_distances(shapes, X_WL, p_WC, i, j):
    """Computes `least_distance` at eight configurations, one per lane.

    Args:
        shapes: The shapes.
        X_WL: Poses of all bodies, see `pose_lanes`.
        p_WC: Centres of the shapes in W, shape (s, 3, 8) [m].
        i: One shape.
        j: The other.
    """
    radius, half = shapes.radius, shapes.half
    reach, body = shapes.reach, shapes.body
    d_W = center_offsets(p_WC, i, j)
    x, y, z = d_W
    best = root(x * x + y * y + z * z) - reach[i] - reach[j]
    along_i = turned_back(X_WL, body[i], d_W)
    along_j = turned_back(X_WL, body[j], d_W)
    best = greatest(best, _to_box(half, i, along_i) - reach[j])
    best = greatest(best, _to_box(half, j, along_j) - reach[i])
    return best - radius[i] - radius[j]


@helper
def center_offsets(p_WC, i, j):
    """Returns the vectors from one centre to another, as three lanes."""
    first, last = 3 * i * WIDTH, 3 * j * WIDTH
    return (
        lanes_from(p_WC, last) - lanes_from(p_WC, first),
        lanes_from(p_WC, last + WIDTH) - lanes_from(p_WC, first + WIDTH),
        lanes_from(p_WC, last + 2 * WIDTH)
        - lanes_from(p_WC, first + 2 * WIDTH),
    )


@helper
def _along(X_WL, x, y, z):
    """Returns the entries of a vector in W along the axes of a link."""
    return (
        X_WL[0, 0] * x + X_WL[1, 0] * y + X_WL[2, 0] * z,
        X_WL[0, 1] * x + X_WL[1, 1] * y + X_WL[2, 1] * z,
        X_WL[0, 2] * x + X_WL[1, 2] * y + X_WL[2, 2] * z,
    )


@helper
def _to_box(half, i, along):
    """Signed distance from a box to a point, numbers or lanes [m].

    `along` is the vector from the centre of the box to the point, along the
    axes of the box; its sign does not matter.
    """
    return distance_to_box(along[0], along[1], along[2], half[i])


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
    """Computes the signed distance of two shapes, or a bound that suffices.

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
