"""Points at which links are near each other, beyond the nearest two.

The nearest points of two links jump. For example, two parallel plates are
nearest at one corner, and at another one after the smallest rotation. A program
with a row for only one corner rotates the plates about it, and the other corner
is too near at the next tick. So this module also returns the points that would
be the nearest after a small rotation of one link, in both senses about two axes
perpendicular to the common normal. Physics engines call this a contact
manifold, found by perturbation.

If a link of several shapes overlaps another link, several pairs of shapes may
overlap. A motion that separates one pair may bring another pair closer. So all
pairs that are too near are returned, not only the nearest one.
"""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import reals, several, wholes
from remosplat_drake.base.vectors import across, rotation
from remosplat_drake.robot.self_collision.kernels.gjk import make_work
from remosplat_drake.robot.self_collision.kernels.pair_distance import (
    centers_in_world,
    least_distance,
    shape_distance,
)
from remosplat_drake.robot.self_collision.kernels.turning import (
    point_to_world,
    turn_back,
    turn_body,
    vector_to_world,
)

_TILT = 0.05
"""Angle of the small rotations [rad]."""

_ASKEW = 0.4
"""Angle between the axes of the small rotations and the world's axes [rad].
Edges are often parallel to the world's axes, and a rotation about an edge makes
neither of its ends nearer."""

_CLOSE = 0.3
"""Links are rotated if their distance is less than this fraction of `within`.
For links farther apart, the nearest points suffice."""

_SAME, _SAME_CROWDED = 0.01, 1e-4
"""Distances below which two points of a link count as the same point [m]:
usually, and for shapes that are too near. The latter distance is smaller, since
the corners of round links are closely spaced, and no corner may come nearer."""

_MOST = 5
"""Largest number of point pairs for two links: the nearest points, and those
that are nearest after each of four rotations."""


@kernel(returns=several(wholes(1), reals(1), reals(2), reals(2), reals(2)))
def near_points(pairs, X_WL, within, crowded):
    """Finds the points at which links are near each other.

    Args:
        pairs: Packed `PairArrays`, with l pairs of links and their k pairs of
            shapes.
        X_WL: Poses of all bodies, shape (b, 4, 4).
        within: Links at or beyond this distance are left out [m]; a negative
            one leaves out all.
        crowded: Distance below which all pairs of shapes of two links are
            returned, not only the nearest pair [m].

    Returns:
        For m pairs of points: the pair of shapes, shape (m,); the distance
        along the normal, allowance included, shape (m,) [m]; the unit normal
        from the first to the second in W, shape (m, 3); and the points on the
        first and on the second in W, shape (m, 3) each [m].
    """
    start, boxes, shapes = pairs.start, pairs.boxes, pairs.shapes
    link_boxes, allowance = pairs.link_boxes, pairs.allowance
    p_WC = centers_in_world(shapes, X_WL)
    p_WL = centers_in_world(link_boxes, X_WL)
    work = make_work()
    most = 1
    for link in range(len(boxes)):
        most = max(most, start[link + 1] - start[link])
    near = _make_points(most)
    found = _make_points(_MOST * (len(boxes) + len(allowance)))
    count = 0
    # Skips links that cannot be near.
    for link in range(len(boxes) if within >= 0.0 else 0):
        a, b = boxes[link]
        span = start[link], start[link + 1]
        apart = least_distance(link_boxes, X_WL, p_WL, a, b)
        if apart + allowance[span[0] : span[1]].max() >= within:
            continue
        reach = crowded, _CLOSE * within, within
        size = _find_near(pairs, span, X_WL, p_WC, reach, near, work)
        if not size:
            continue
        nearest = near[1][:size].argmin()
        for i in range(size):
            if i == nearest or near[1][i] < crowded:
                # After a rotation, another pair of shapes may be the nearest; a
                # pair that is only crowded is not rotated.
                known = (near, 0, size) if i == nearest else (near, i, i + 1)
                same = _SAME_CROWDED if near[1][i] < crowded else _SAME
                is_close = near[1][i] < _CLOSE * within
                count = _note(
                    (pairs, X_WL, p_WC, within),
                    known,
                    i,
                    is_close,
                    same,
                    found,
                    count,
                    work,
                )
    return (
        found[0][:count],
        found[1][:count],
        found[2][:count],
        found[3][:count],
        found[4][:count],
    )


@helper
def _make_points(n):
    """Makes the arrays that `near_points` returns, for n pairs of points."""
    return (
        np.empty(n, np.int64),
        np.empty(n),
        np.empty((n, 3)),
        np.empty((n, 3)),
        np.empty((n, 3)),
    )


@helper
def _find_near(pairs, span, X_WL, p_WC, reach, near, work):
    """Finds the nearest points of two links, and of other near shapes.

    Shapes that may be nearest are examined first. Other shapes are included if
    they are crowded, or if a small rotation of the second link about its
    nearest point could make them the nearest.

    Args:
        pairs: The pairs of shapes.
        span: The first pair of the two links, and the one after their last.
        X_WL: Poses of all bodies.
        p_WC: Centres of the shapes in W.
        reach: Distances below which shapes are crowded, links are rotated, and
            links are near [m].
        near: Output: the arrays of `_make_points`, filled with the pairs of
            points.
        work: Working arrays of GJK.

    Returns:
        The number of pairs of points.
    """
    first, second, allowance = pairs.first, pairs.second, pairs.allowance
    shapes, body = pairs.shapes, pairs.shapes.body
    n = span[1] - span[0]
    least, guess_W = np.empty(n), np.empty(3)
    for i in range(n):
        k = span[0] + i
        apart = least_distance(shapes, X_WL, p_WC, first[k], second[k])
        least[i] = apart + allowance[k]
    crowded, close, within = reach
    size, nearest, best = 0, 0, np.inf
    for _ in range(n):
        i = least.argmin()
        if least[i] >= within:
            break
        k = span[0] + i
        enough = min(max(best, crowded), within)
        if best < close:
            band = _greatest_shift(shapes, p_WC, second[k], near[4][nearest])
            enough = min(max(best + band, crowded), within)
        is_far = least[i] >= enough
        least[i] = np.inf
        if is_far:
            continue
        for c in range(3):
            guess_W[c] = p_WC[second[k], c] - p_WC[first[k], c]
            if size:
                guess_W[c] = near[2][nearest, c]
        X_WA, X_WB = X_WL[body[first[k]]], X_WL[body[second[k]]]
        gap, x, y, z = shape_distance(
            shapes,
            X_WA,
            X_WB,
            (first[k], second[k]),
            guess_W,
            enough - allowance[k],
            work,
        )
        gap += allowance[k]
        if gap >= enough:
            continue
        if gap < best:
            nearest, best = size, gap
        near[0][size], near[1][size] = k, gap
        vector_to_world(X_WA, (x, y, z), near[2][size])
        point_to_world(X_WA, work[-1][0], near[3][size])
        point_to_world(X_WA, work[-1][1], near[4][size])
        size += 1
    return size


@helper
def _note(given, known, i, is_close, same, found, count, work):
    """Stores a pair of points, and the pairs nearest after small rotations.

    Args:
        given: The pairs, the poses of all bodies, the centres of the shapes in
            W, and the largest distance.
        known: Pairs of points of two links, and which of them are rotated.
        i: Index of the pair of points to store.
        is_close: Whether links are rotated.
        same: Distance below which points count as one [m].
        found: Output: the arrays of `_make_points`, filled with the pairs of
            points.
        count: Number of pairs stored so far.
        work: Working arrays of GJK.

    Returns:
        The number of pairs stored afterwards.
    """
    pairs, X_WL, p_WC, within = given
    near, first = known[0], count
    _copy(near, i, found, count)
    count += 1
    axes = across(near[2][i], _ASKEW)
    for turn in range(4 if is_close else 0):
        R = rotation(axes[turn // 2], _TILT if turn % 2 else -_TILT)
        _find_turned((pairs, X_WL, p_WC), known, R, found, count, work)
        gap = found[1][count]
        if gap < within and not _is_known(found, first, count, same):
            count += 1
    return count


@helper
def _find_turned(given, known, R, found, row, work):
    """Finds the points that are nearest after rotating the second link by R.

    The link is rotated about its point nearest to the first link. Stored are
    the corresponding points of the unrotated link, with the distance along the
    normal of their unrotated shapes.
    """
    pairs, X_WL, p_WC = given
    first, second, allowance = pairs.first, pairs.second, pairs.allowance
    shapes = pairs.shapes
    radius, body = shapes.radius, shapes.body
    near, begin, end = known
    X_turned = np.empty((4, 4))
    nearest = begin + near[1][begin:end].argmin()
    center = near[4][nearest]
    best, chosen = np.inf, nearest
    for turn in range(begin - 1, end):
        # Starts with the nearest; most others cannot come as near.
        n = nearest if turn < begin else turn
        k = near[0][n]
        shift = _greatest_shift(shapes, p_WC, second[k], center)
        if near[1][n] - shift >= best or turn == nearest:
            continue
        X_WA = X_WL[body[first[k]]]
        turn_body(R, center, X_WL[body[second[k]]], X_turned)
        gap, _, _, _ = shape_distance(
            shapes,
            X_WA,
            X_turned,
            (first[k], second[k]),
            near[2][n],
            best - allowance[k],
            work,
        )
        if gap + allowance[k] < best:
            best, chosen = gap + allowance[k], n
            point_to_world(X_WA, work[-1][0], found[3][row])
            point_to_world(X_WA, work[-1][1], found[4][row])
    turn_back(R, center, found[4][row])
    k = near[0][chosen]
    found[0][row] = k
    gap = allowance[k] - radius[first[k]] - radius[second[k]]
    for c in range(3):
        found[2][row, c] = near[2][chosen, c]
        gap += found[2][row, c] * (found[4][row, c] - found[3][row, c])
    found[1][row] = gap


@helper
def _greatest_shift(shapes, p_WC, shape, center):
    """Bounds the motion of a shape's points by a rotation about a point [m]."""
    square = 0.0
    for c in range(3):
        square += (p_WC[shape, c] - center[c]) ** 2
    return _TILT * (np.sqrt(square) + shapes.reach[shape])


@helper
def _copy(near, i, found, row):
    """Copies a pair of points from one set of arrays to another."""
    found[0][row], found[1][row] = near[0][i], near[1][i]
    for c in range(3):
        found[2][row, c] = near[2][i, c]
        found[3][row, c] = near[3][i, c]
        found[4][row, c] = near[4][i, c]


@helper
def _is_known(found, first, row, same):
    """Returns whether an earlier pair has the same points."""
    for i in range(first, row):
        far = 0.0
        for p_W in found[3:]:
            square = 0.0
            for c in range(3):
                step = p_W[i, c] - p_W[row, c]
                square += step * step
            far = max(far, square)
        if far < same * same:
            return True
    return False
