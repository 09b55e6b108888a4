"""Checks distances from a map, at a configuration or along a motion.

A part of a motion is sampled in its middle. The room of a sphere is its
clearance minus the required clearance. If the room in the middle exceeds the
length of the sphere's path from there to either end, the sphere is free on the
part. For other spheres, the part is halved, and both middles are sampled. Balls
that each enclose several spheres are checked first.
"""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import TRUTH, reals
from remosplat_drake.base.vectors import set_vector
from remosplat_drake.controller.verification.kernels.between_looks import (
    TOLERANCE,
    bend_of,
    longest_way,
)
from remosplat_drake.robot.kinematics import (
    advance,
    body_poses,
    copy_poses,
    sphere_points,
)
from remosplat_drake.robot.self_collision.kernels.turning import point_to_world
from remosplat_drake.signals.compiled_map import (
    is_compiled,
    is_lipschitz,
    sphere_clearances,
)

_HALVES = 10
"""Number of halvings after which a motion that is still undecided counts as not
free."""

_SOME = 4
"""Number of spheres between two checks for an interruption."""

_MARGIN = 1e-6
"""Margin of queried distances against rounding [m]."""


_ROUNDING = 1e-9
"""Bound on rounding errors of distances [m]."""


@kernel(returns=TRUTH)
def is_off_the_map(space, line, X_WL):
    """Returns whether all spheres keep their clearances at a configuration.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of its map.
        X_WL: Poses of all bodies, shape (b, 4, 4).
    """
    order, item, bend = space.ball_order, space.work.item, space.work.bend
    part = X_WL, X_WL, X_WL, 0.0, bend, bend, -_ROUNDING
    for first in range(0, len(order), _SOME):
        count = min(len(order) - first, _SOME)
        for k in range(count):
            item[k] = order[first + k]
        if _look_at(space, line, part, item, count) != 0:
            # These often collide the next time, too, so they are checked first.
            for k in range(count):
                order[k], order[first + k] = order[first + k], order[k]
            return False
    return True


@kernel(returns=reals(2))
def rooms(space, line, q, far):
    """Measures the rooms of spheres: clearances minus required ones.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of its map.
        q: Configurations, shape (k, n_q) [rad, m].
        far: Value at which rooms are truncated [m].

    Returns:
        The rooms, shape (k, n) [m].
    """
    robot, n = space.robot, len(space.level)
    found, wanted = np.full((len(q), n), -np.inf), np.full(n, far)
    for k in range(len(q)):
        X_WL, _ = body_poses(robot.tree, q[k])
        at = sphere_points(X_WL, robot.body_S, robot.p_LS)
        look(space, line, at, wanted, found[k], 0.0)
        for i in range(n):
            if found[k, i] > far:
                found[k, i] = far
    return found


@kernel(returns=TRUTH)
def keeps_off_the_map(space, line, q, u, looks):
    """Returns whether all spheres keep their clearances along a motion.

    Between samples, clearances may be smaller by verification's tolerance. For
    a map that is not 1-Lipschitz, clearances are kept only at the samples.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of its map.
        q: Configuration at which it starts, shape (n_q,) [rad, m].
        u: The command, which is held for a second, shape (n_u,).
        looks: Number of equal parts into which the motion is divided at first.
    """
    tree, n_base, balls = space.robot.tree, space.robot.n_base, space.balls
    m, speed, b = len(space.ball_level), np.abs(u), len(tree.parent)
    bend = space.work.bend
    bend[:] = -1.0
    # A stack of times, with the motion's end at the bottom. The next part is
    # between the two topmost times.
    most = looks + 1 + _HALVES
    time, X_WL = np.empty(most), np.empty((most, b, 4, 4))
    item, count = np.empty((most, m), np.int64), np.empty(most, np.int64)
    for k in range(looks + 1):
        time[k] = 1.0 - k / looks
        X, _ = body_poses(tree, advance(q, u, n_base, time[k]))
        copy_poses(X, X_WL[k])
        count[k] = len(balls.first) - 1
        for i in range(count[k]):
            item[k, i] = i
    top = looks
    while top > 0:
        half = 0.5 * (time[top - 1] - time[top])
        X, _ = body_poses(tree, advance(q, u, n_base, time[top] + half))
        part = X_WL[top], X, X_WL[top - 1], half, speed, bend, -TOLERANCE
        left = _look_at(space, line, part, item[top], count[top])
        if left == 0:
            top -= 1
            continue
        if left < 0 or top + 1 == most:
            return False
        count[top] = count[top + 1] = left
        for i in range(left):
            item[top + 1, i] = item[top, i]
        time[top + 1] = time[top]
        time[top] += half
        copy_poses(X_WL[top], X_WL[top + 1])
        copy_poses(X, X_WL[top])
        top += 1
    return True


@helper
def _look_at(space, line, part, item, count):
    """Checks balls and spheres, and keeps those that need more samples.

    A ball that may not be clear is replaced by its spheres.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of its map.
        part: A part of a motion: poses of all bodies at its start, middle and
            end, shape (b, 4, 4) each; half its duration [s]; absolute values of
            the command; bounds on the accelerations of the m balls and spheres,
            -1 if not computed yet, shape (m,) [m/s^2]; and the least room to
            keep [m].
        item: Input: balls and spheres to check, shape (m,); output: the spheres
            that may not be clear on the whole part.
        count: Number of balls and spheres to check.

    Returns:
        Number of these spheres; -1 if one has too little room in the middle.
    """
    balls, least = space.balls, part[6]
    groups, left = len(balls.first) - 1, 0
    room, wanted, opened = space.work.room, space.work.wanted, space.work.opened
    while count > 0:
        _measure(space, line, part, item[left : left + count], room, wanted)
        kept, opens = left, 0
        for row in range(count):
            i = item[left + row]
            if room[row] >= wanted[row]:
                continue
            if i < groups:
                opened[opens] = i
                opens += 1
                continue
            if not room[row] >= least:
                return -1
            item[kept] = i
            kept += 1
        left, count = kept, 0
        for k in range(opens):
            first, end = balls.first[opened[k]], balls.first[opened[k] + 1]
            for place in range(first, end):
                item[left + count] = balls.member[place]
                count += 1
    return left


@helper
def _measure(space, line, part, item, room, wanted):
    """Measures rooms in the middle of a part, exactly up to the needed ones.

    A sphere is clear on the whole part if its room is at least the length of
    its path to either end, minus the tolerance.
    """
    before, middle, after, half, speed, bend, least = part
    balls, level, count = space.balls, space.ball_level, len(item)
    work, p = space.work, space.work.p_before
    p_WS, reach, found = work.p_WS[:count], work.reach, work.found[:count]
    for row in range(count):
        i, way = item[row], 0.0
        body, p_LS = balls.body[i], balls.p_LS[i]
        point_to_world(middle[body], p_LS, p_WS[row])
        if half > 0.0:
            if bend[i] < 0.0:
                bend[i] = bend_of(balls.hessian_bound[i], speed)
            point_to_world(before[body], p_LS, p)
            way = longest_way(p, p_WS[row], bend[i], half)
            point_to_world(after[body], p_LS, p)
            way = max(way, longest_way(p, p_WS[row], bend[i], half))
        wanted[row] = way + least
        reach[row] = level[i] + max(wanted[row], 0.0) + _MARGIN
    if is_compiled(space.map):
        # Only maps in Python use orientations.
        placed, none = (space.map, space.off, line), space.balls.hessian_bound
        sphere_clearances(placed, balls, item, p_WS, none, reach, found)
    else:
        _measure_in_python(space, line, (middle, p_WS), item, reach, found)
    for row in range(count):
        room[row] = found[row] - level[item[row]]
        if not is_lipschitz(space.map):
            wanted[row] = least


@helper
def _measure_in_python(space, line, at, item, reach, found):
    """Measures clearances with a map in Python, which supports only spheres."""
    X_WL, p_WS = at
    balls, groups, count = space.balls, len(space.balls.first) - 1, len(item)
    if item[0] < groups:
        found[:] = -np.inf
        return
    sphere, R_WL = item - groups, np.empty((count, 3, 3))
    for row in range(count):
        for r in range(3):
            set_vector(R_WL[row, r], X_WL[balls.body[item[row]], r])
    placed = space.map, space.off, line
    sphere_clearances(placed, space.robot, sphere, p_WS, R_WL, reach, found)


@helper
def look(space, line, at, wanted, room, least):
    """Queries the map for spheres whose lower bounds of rooms are too small.

    The room of a sphere is its clearance minus the required clearance.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of its map.
        at: Centres of the spheres in W, shape (n, 3) [m], and the orientations
            of their links, shape (n, 3, 3).
        wanted: Rooms up to which results are exact, shape (n,) [m].
        room: Input: lower bounds on the rooms; output: queried rooms, shape
            (n,) [m].
        least: Least permitted room [m].

    Returns:
        Whether all rooms are at least that.
    """
    p_WS, R_WL = at
    n, count = len(room), 0
    sphere = np.empty(n, np.int64)
    for i in range(n):
        if not room[i] > wanted[i]:
            sphere[count] = i
            count += 1
    if count == 0:
        return True
    sphere = sphere[:count]
    p, R = np.empty((count, 3)), np.empty((count, 3, 3))
    reach, found = np.empty(count), np.empty(count)
    for row in range(count):
        i = sphere[row]
        set_vector(p[row], p_WS[i])
        for r in range(3):
            set_vector(R[row, r], R_WL[i, r])
        reach[row] = space.level[i] + wanted[i] + _MARGIN
    placed = space.map, space.off, line
    sphere_clearances(placed, space.robot, sphere, p, R, reach, found)
    is_kept = True
    for row in range(count):
        i = sphere[row]
        room[i] = found[row] - space.level[i]
        is_kept &= room[i] >= least
    return is_kept
