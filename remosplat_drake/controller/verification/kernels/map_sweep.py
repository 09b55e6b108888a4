"""Checks that spheres keep their distances from a map along a path.

The map is queried first at coarse and then at finer samples. A path that is
still undecided at the finest samples is rejected. For a map that is not
1-Lipschitz, nothing is guaranteed between the sampled configurations.
"""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import TRUTH
from remosplat_drake.controller.verification.kernels.between_samples import (
    apart,
    longest_way,
)
from remosplat_drake.controller.verification.kernels.path_samples import (
    sample_path,
)
from remosplat_drake.controller.verification.kernels.places import place
from remosplat_drake.robot.kinematics import body_poses
from remosplat_drake.signals.compiled_map import (
    is_lipschitz,
    sphere_clearances,
)

PIECES = 4
"""Number of pieces into which the time between two samples is divided."""

ROUNDS = 5
"""Number of times that a piece is divided again. A path that is undecided with
4^5 pieces is rejected."""


@kernel(returns=TRUTH)
def sweeps_clear(robot, path, placed, p_WS, clearance, level, tolerance):
    """Returns whether all spheres keep their distance from a map on a path.

    At the `times` of the path, the spheres must keep the distance. Between
    these times, they must keep the distance minus a tolerance; see
    `between_samples.py`.

    Args:
        robot: The `RobotArrays`.
        path: The `PathArrays`.
        placed: The map, its `Misplacement`, and the number of the
            `PythonCalls`; see `compiled_map.sphere_clearances`.
        p_WS: Centres of the spheres in W at the start, shape (n, 3) [m].
        clearance: Clearances of the spheres at the start, or lower bounds of
            these clearances, shape (n,) [m].
        level: Clearance that each sphere must keep, shape (n,) [m].
        tolerance: Amount by which each clearance may fall below its level
            between the path's times, shape (n,) [m].
    """
    knows_between = is_lipschitz(placed[0])
    if knows_between:
        near = _within_reach(robot, path, clearance - level)
    else:
        near = np.arange(len(level))
    if len(near) == 0:
        return True
    level, tolerance, start = level[near], tolerance[near], p_WS[near]
    at_start = clearance[near] - level
    point, R_WL, bend, way, margin, wanted = sample_path(
        robot, path, near, start, at_start, tolerance
    )
    k, n = margin.shape
    reach = level.max()
    if knows_between:
        reach += wanted.max()
    queries = np.empty((k * n, 2), np.int64)
    count = 0
    for j in range(k):
        for i in range(n):
            if not (knows_between and margin[j, i] > wanted[j, i]):
                queries[count, 0], queries[count, 1] = j, i
                count += 1
    sphere, p = np.empty(count, np.int64), np.empty((count, 3))
    R = np.empty((count, 3, 3))
    for row in range(count):
        j, i = queries[row]
        sphere[row] = near[i]
        for c in range(3):
            p[row, c] = point[j + 1, i, c]
            for r in range(3):
                R[row, r, c] = R_WL[j, i, r, c]
    found = np.empty(count)
    sphere_clearances(placed, robot, sphere, p, R, reach, found)
    for row in range(count):
        j, i = queries[row]
        margin[j, i] = found[row] - level[i]
        if not margin[j, i] >= 0.0:
            return False
    if not knows_between:
        return True
    times = path.times
    for i in range(n):
        before, time = at_start[i], 0.0
        for j in range(k):
            after = margin[j, i]
            if not before + after - way[j, i] >= -2.0 * tolerance[i]:
                gap = near[i], level[i], at_start[i], bend[i], reach
                ends = time, times[j], before, after
                places = start[i], point[j, i], point[j + 1, i]
                if not _clear_between(
                    robot, path, placed, gap, ends, places, tolerance[i]
                ):
                    return False
            before, time = after, times[j]
    return True


@helper
def _within_reach(robot, path, margin):
    """Finds the spheres that may come too near to the scene on a path."""
    near, count = np.empty(len(margin), np.int64), 0
    for i in range(len(margin)):
        if not travel_of(robot, path, i) < margin[i]:
            near[count] = i
            count += 1
    return near[:count]


@helper
def travel_of(robot, path, i):
    """Returns a bound of the length of a sphere's motion along a path [m].

    Args:
        robot: The `RobotArrays`.
        path: The `PathArrays`.
        i: The sphere.
    """
    rates, since, times = path.rates, path.since, path.times
    travel = 0.0
    for s in range(len(since)):
        end = since[s + 1] if s + 1 < len(since) else times[-1]
        speed = 0.0
        for j in range(rates.shape[1]):
            speed += robot.jacobian_bound[i, j] * abs(rates[s, j])
        travel += speed * (end - since[s])
    return travel


@helper
def _clear_between(robot, path, placed, gap, ends, places, tolerance):
    """Checks a sphere between two times; divides the interval if needed.

    Args:
        robot: The `RobotArrays`.
        path: The `PathArrays`.
        placed: The map.
        gap: The sphere, its level, its margin at the start, the bound of its
            acceleration, and the largest queried distance.
        ends: The two times, and the sphere's margins at these times.
        places: The sphere's centres at the start of the path, and at the two
            times.
        tolerance: Amount by which the clearance may fall below its level [m].
    """
    i, level, at_start, bend, reach = gap
    start, p_before, p_after = places
    # The stack contains the remaining pieces: times and margins at their ends,
    # and their depths.
    most = ROUNDS * PIECES
    left = np.empty((most, 4))
    centers = np.empty((most, 2, 3))
    depths = np.zeros(most, np.int64)
    for c in range(4):
        left[0, c] = ends[c]
    centers[0, 0], centers[0, 1] = p_before, p_after
    count = 1
    sphere = np.full(1, i)
    p, found = np.empty((PIECES + 1, 3)), np.empty(1)
    R = np.empty((PIECES + 1, 3, 3))
    margin, way = np.empty(PIECES + 1), np.empty(PIECES)
    while count:
        count -= 1
        depth = depths[count]
        if depth == ROUNDS:
            return False
        begin, end = left[count, 0], left[count, 1]
        margin[0], margin[PIECES] = left[count, 2], left[count, 3]
        p[0], p[PIECES] = centers[count, 0], centers[count, 1]
        span = (end - begin) / PIECES
        for k in range(1, PIECES):
            _place(robot, path, begin + k * span, i, p[k], R[k])
        for k in range(PIECES):
            way[k] = longest_way(p[k], p[k + 1], bend, span)
        for k in range(1, PIECES):
            margin[k] = at_start - apart(start, p[k])
            wanted = max(0.5 * max(way[k - 1], way[k]) - tolerance, 0.0)
            if not margin[k] > wanted:
                one = slice(k, k + 1)
                sphere_clearances(
                    placed, robot, sphere, p[one], R[one], reach, found
                )
                margin[k] = found[0] - level
            if not margin[k] >= -tolerance:
                return False
        for k in range(PIECES):
            if margin[k] + margin[k + 1] - way[k] >= -2.0 * tolerance:
                continue
            left[count, 0] = begin + k * span
            left[count, 1] = begin + (k + 1) * span
            left[count, 2], left[count, 3] = margin[k], margin[k + 1]
            centers[count, 0], centers[count, 1] = p[k], p[k + 1]
            depths[count] = depth + 1
            count += 1
    return True


@helper
def _place(robot, path, time, i, p, R):
    """Writes a sphere's position and orientation at a time on a path."""
    X_WB, _ = body_poses(robot.tree, place(path, time))
    X = X_WB[robot.body_S[i]]
    for r in range(3):
        p[r] = X[r, 3]
        for c in range(3):
            p[r] += X[r, c] * robot.p_LS[i, c]
            R[r, c] = X[r, c]


@helper
def keeps_joint_limits(path, lower, upper):
    """Returns whether joints stay within their limits.

    A joint that is outside its limits at the start must not move farther
    outside.

    On each piece of a path, joints move monotonically, so only the ends of the
    pieces are checked.

    Args:
        path: The `PathArrays`.
        lower: Lower limits, shape (n_q,) [rad, m].
        upper: Upper limits, shape (n_q,) [rad, m].
    """
    starts, times = path.starts, path.times
    last = place(path, times[-1])
    for k in range(len(starts) + 1):
        for i in range(len(last)):
            q = starts[k, i] if k < len(starts) else last[i]
            least, most = (
                min(lower[i], starts[0, i]),
                max(upper[i], starts[0, i]),
            )
            if not (least <= q <= most and np.isfinite(q)):
                return False
    return True
