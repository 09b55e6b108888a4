"""Checks that pairs of convex shapes keep their distances along a path.

A pair is first checked at the start and the end of the path. It is checked in
between only if these two samples are not sufficient.
"""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import TRUTH
from remosplat_drake.base.vectors import norm, set_vector
from remosplat_drake.controller.verification.kernels.between_samples import (
    tolerated,
)
from remosplat_drake.controller.verification.kernels.places import (
    peak_speed,
    place,
)
from remosplat_drake.controller.verification.kernels.relative_way import (
    relative_bend,
    relative_way,
    travels,
)
from remosplat_drake.robot.kinematics import body_poses, copy_poses
from remosplat_drake.robot.self_collision.kernels.gjk import make_work
from remosplat_drake.robot.self_collision.kernels.pair_distance import (
    centers_in_world,
    distance_beyond,
    least_distance,
)

_HALVINGS = 10
"""Number of times that a tick is halved. If the path is still undecided, it is
rejected."""


@kernel(returns=TRUTH)
def pairs_keep_apart(tree, path, own, stopping, off):
    """Returns whether all pairs of shapes keep their distances on a path.

    The distance that a pair must keep is min(stopping, its present distance).
    Between the times of the path, distances may be smaller by the amount that
    `tolerated` computes.

    Args:
        tree: The `TreeArrays`, packed.
        path: The `PathArrays`.
        own: The pairs, in the form of `SelfClearance.arrays`.
        stopping: Stopping distance of all pairs [m].
        off: Additional distance for each of l pairs of links, shape (l,) [m].
            It is needed since the robot may deviate from its path.
    """
    pairs, rate, lever, turns = own.pairs, own.rate, own.lever, own.turns
    first, second, start = pairs.first, pairs.second, pairs.start
    allowance, boxes = pairs.allowance, pairs.boxes
    shapes, link_boxes = pairs.shapes, pairs.link_boxes
    center, reach, body = shapes.center, shapes.reach, shapes.body
    speed, times = peak_speed(path.rates), path.times
    travel = travels(path, rate)
    knots = np.zeros(len(times) + 1)
    for i in range(len(times)):
        knots[i + 1] = times[i]
    X_WL = np.empty((len(knots), len(tree.parent), 4, 4))
    p_WC = np.empty((len(knots), len(body), 3))
    is_placed = np.zeros(len(knots), np.bool_)
    _place(tree, shapes, path, 0.0, X_WL[0], p_WC[0])
    is_placed[0] = True
    p_WL = centers_in_world(link_boxes, X_WL[0])
    samples = knots, X_WL, p_WC, is_placed
    work = make_work()
    for link in range(len(boxes)):
        farthest = travel[link, -1]
        # If neither link moves, the distance counts as constant, despite
        # rounding errors.
        if farthest == 0.0:
            continue
        a, b = boxes[link]
        apart = least_distance(link_boxes, X_WL[0], p_WL, a, b)
        for k in range(start[link], start[link + 1]):
            kept = stopping - allowance[k]
            enough = kept + off[link] + farthest
            if apart > enough:
                continue
            pair = first[k], second[k]
            found = distance_beyond(
                shapes, X_WL[0], p_WC[0], pair, enough, work
            )
            if found > enough:
                continue
            level = min(found, kept + off[link])
            i, j = pair
            offset = norm(center[j])
            bend = relative_bend(lever[link], turns, speed, offset, reach[j])
            if not _pair_keeps_apart(
                (tree, shapes, path),
                samples,
                (i, j, level, bend),
                travel[link],
                found - level,
                tolerated(level, kept),
                work,
            ):
                return False
    return True


@helper
def _pair_keeps_apart(given, samples, pair, travel, margin, tolerance, work):
    """Checks a pair; poses that were computed for other pairs are reused."""
    tree, shapes, path = given
    knots, X_WL, p_WC, is_placed = samples
    # The path before `left` is clear. The next part of the path ends at the
    # last entry of `rights`. If this part is too long, it is halved.
    left = 0
    rights = np.empty(64, np.int64)
    rights[0] = len(knots) - 1
    height = 1
    while height:
        right = rights[height - 1]
        if not is_placed[right]:
            _place(tree, shapes, path, knots[right], X_WL[right], p_WC[right])
            is_placed[right] = True
        time = knots[right] - knots[left]
        if right - left > 1 and len(travel) == len(knots):
            # Inside this part, velocities change instantly from piece to piece.
            way = travel[right] - travel[left]
        else:
            way = _way(shapes, X_WL[left], X_WL[right], pair, time)
        margin_after = _margin(
            shapes, X_WL[right], p_WC[right], pair, way, work
        )
        if not margin_after >= 0.0:
            return False
        if not margin + margin_after - way >= 0.0:
            if right - left > 1:
                rights[height] = (left + right) // 2
                height += 1
                continue
            if not _keeps_apart_within(
                given,
                samples,
                pair,
                right,
                (margin, margin_after),
                tolerance,
                work,
            ):
                return False
        left, margin = right, margin_after
        height -= 1
    return True


@helper
def _keeps_apart_within(given, samples, pair, knot, margins, tolerance, work):
    """Checks a pair within the tick that ends at a knot.

    Within a tick, the distance may fall below its level by the tolerance.
    """
    tree, shapes, path = given
    knots, X_WL, p_WC, _ = samples
    begin, end = knots[knot - 1], knots[knot]
    shortest = 0.5**_HALVINGS * (end - begin)
    rights = np.empty((_HALVINGS + 2, 2))
    X_rights = np.empty((_HALVINGS + 2, *X_WL[0].shape))
    rights[0, 0], rights[0, 1] = end, margins[1]
    copy_poses(X_WL[knot], X_rights[0])
    left, margin, X_left = begin, margins[0], X_WL[knot - 1].copy()
    centers = np.empty_like(p_WC[0])
    height = 1
    while height:
        right, margin_after = rights[height - 1, 0], rights[height - 1, 1]
        X_right = X_rights[height - 1]
        way = _way(shapes, X_left, X_right, pair, right - left)
        if margin + margin_after - way >= -2.0 * tolerance:
            left, margin = right, margin_after
            copy_poses(X_right, X_left)
            height -= 1
            continue
        if right - left <= shortest:
            return False
        middle = 0.5 * (left + right)
        X_middle = X_rights[height]
        _place(tree, shapes, path, middle, X_middle, centers)
        rights[height, 0] = middle
        rights[height, 1] = _margin(shapes, X_middle, centers, pair, way, work)
        if not rights[height, 1] >= -tolerance:
            return False
        height += 1
    return True


@helper
def _place(tree, shapes, path, time, X_WL, p_WC):
    """Places all bodies, and the centres of all shapes, at a time."""
    placed, _ = body_poses(tree, place(path, time))
    copy_poses(placed, X_WL)
    centers = centers_in_world(shapes, X_WL)
    for i in range(len(centers)):
        set_vector(p_WC[i], centers[i])


@helper
def _margin(shapes, X_WL, p_WC, pair, way, work):
    """Returns a pair's distance minus its level [m].

    The result may be a lower bound, if this bound exceeds the lengths of the
    paths before and after the sample.
    """
    i, j, level, _ = pair
    enough = level + 2.0 * way
    return distance_beyond(shapes, X_WL, p_WC, (i, j), enough, work) - level


@helper
def _way(shapes, X_WL, Y_WL, pair, time):
    """Returns a bound of the second shape's path relative to the first [m]."""
    center, reach, body = shapes.center, shapes.reach, shapes.body
    i, j, _, bend = pair
    return relative_way(
        X_WL, Y_WL, body[i], body[j], center[j], reach[j], bend, time
    )
