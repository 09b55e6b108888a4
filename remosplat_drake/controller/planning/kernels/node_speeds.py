"""Computes the nodes of a path, and the greatest speeds at the nodes.

The speeds keep the robot's limits and the law of the collision damper; see
`timing.py`.
"""

import math

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import reals, several
from remosplat_drake.controller.ingredients.path_tracking import CREEP
from remosplat_drake.controller.planning.kernels.controllable_speeds import (
    controllable_speeds,
)
from remosplat_drake.controller.planning.kernels.damper_speeds import (
    damper_speeds,
)
from remosplat_drake.controller.planning.steering import segment_commands
from remosplat_drake.robot.inverse_dynamics import inverse_dynamics

_STEP = 0.06
"""Speeds are computed at points of a path that are at most this distance apart.
In this distance, a radian counts like a metre."""

_SHARE = 0.9
"""Fraction of the limits of acceleration and torque that a path uses. The rest
is available for corrections."""

_SHARP = 0.3
"""If the direction changes at a node by more than this angle, the node is a
corner, and not a part of a bend [rad]."""

_SAME = 1e-9
"""Distance up to which two consecutive nodes count as one."""

_LEAST_RATE = 1e-9
"""Rates below this value do not limit the speed."""


@kernel(returns=several(reals(2), reals(1)))
def path_nodes(corners):
    """Returns the corners of a path and points between them.

    Args:
        corners: The corners, shape (m, n_q) [rad, m]. Equal consecutive corners
            count as one.

    Returns:
        The nodes, shape (k + 1, n_q) [rad, m], and the arc length to each node,
        shape (k + 1,).
    """
    m, n = corners.shape
    pieces, most = np.empty(m, np.int64), 1
    for i in range(1, m):
        way = _distance(corners[i - 1], corners[i])
        pieces[i] = max(math.ceil(way / _STEP), 1)
        most += pieces[i]
    q, s, count = np.empty((most, n)), np.zeros(most), 1
    for j in range(n):
        q[0, j] = corners[0, j]
    for i in range(1, m):
        for piece in range(pieces[i]):
            share = (piece + 1) / pieces[i]
            for j in range(n):
                change = corners[i, j] - corners[i - 1, j]
                q[count, j] = corners[i - 1, j] + share * change
            step = _distance(q[count - 1], q[count])
            if step > _SAME:
                s[count] = s[count - 1] + step
                count += 1
    return q[:count].copy(), s[:count].copy()


@helper
def _distance(a, b):
    """Returns the Euclidean distance of two configurations."""
    square = 0.0
    for j in range(len(a)):
        square += (b[j] - a[j]) ** 2
    return math.sqrt(square)


@kernel(returns=several(reals(1), reals(2)))
def node_speeds(space, line, masses, most, path, law):
    """Computes the greatest speeds at the nodes of a path.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of the map.
        masses: The `MassArrays` of the robot.
        most: Largest torques of the arm's joints, shape (n_arm,) [N m, N].
        path: The nodes, shape (k + 1, n_q) [rad, m], and the arc length to each
            node, shape (k + 1,), of at least two nodes.
        law: The slope of the collision damper's law [1/s], the stopping
            distance [m], and the control period [s].

    Returns:
        The results of `controllable_speeds`.
    """
    robot, (q, s), (slope, stopping, dt) = space.robot, path, law
    k, n_u = len(q) - 1, len(robot.velocity_limit)
    rate = segment_commands(q, robot.n_base)
    for i in range(k):
        for c in range(n_u):
            rate[i, c] /= s[i + 1] - s[i]
    turn, bend, is_sharp = _turns(rate, s)
    fastest = np.empty(k)
    for i in range(k):
        fastest[i] = _fastest(rate[i], robot.velocity_limit, 1.0)
        if i > 0:
            before = _fastest(rate[i - 1], robot.velocity_limit, 1.0)
            fastest[i] = min(fastest[i], before)
    fastest = damper_speeds(
        space, line, path, fastest, (slope, stopping, CREEP)
    )
    for i in range(k):
        if is_sharp[i]:
            # The command changes instantly. The change must be at most that
            # which is permitted in one control period.
            share = _SHARE * dt
            through = _fastest(turn[i], robot.acceleration_limit, share)
            fastest[i] = min(fastest[i], through)
    torque, limit = _torques(robot.tree, masses, path, most)
    n = n_u + len(most)
    all_rates, all_bends = np.empty((k, n)), np.empty((k, n))
    offset, bound = np.zeros((k, n)), np.empty(n)
    for c in range(n_u):
        bound[c] = _SHARE * robot.acceleration_limit[c]
    for c in range(len(most)):
        bound[n_u + c] = limit[c]
    for i in range(k):
        for c in range(n_u):
            all_rates[i, c], all_bends[i, c] = rate[i, c], bend[i, c]
        for c in range(len(most)):
            j = q.shape[1] - len(most) + c
            at_rest = torque[i, 0, j]
            all_rates[i, n_u + c] = torque[i, 1, j] - at_rest
            all_bends[i, n_u + c] = torque[i, 2, j] - at_rest
            offset[i, n_u + c] = at_rest
    step = np.empty(k)
    for i in range(k):
        step[i] = s[i + 1] - s[i]
    return controllable_speeds(
        all_rates, all_bends, offset, bound, step, fastest
    )


@helper
def _fastest(rate, limit, share):
    """Returns the greatest v with |rate| v <= share * limit [1/s]."""
    fastest = np.inf
    for c in range(len(rate)):
        bound = share * limit[c] / max(abs(rate[c]), _LEAST_RATE)
        fastest = min(fastest, bound)
    return fastest


@helper
def _turns(rate, s):
    """Returns the changes of a rate at the nodes, in total and per arc length.

    Returns:
        Both changes, each of shape (k, m), and whether the change at each node
        is sharp, shape (k,). If a change is sharp, its change per arc length is
        set to zero.
    """
    k, m = rate.shape
    turn, bend = np.zeros((k, m)), np.zeros((k, m))
    is_sharp = np.zeros(k, np.bool_)
    for i in range(1, k):
        around, square = 0.5 * (s[i + 1] - s[i - 1]), 0.0
        for c in range(m):
            turn[i, c] = rate[i, c] - rate[i - 1, c]
            square += turn[i, c] ** 2
        is_sharp[i] = math.sqrt(square) > _SHARP
        if not is_sharp[i]:
            for c in range(m):
                bend[i, c] = turn[i, c] / around
    return turn, bend, is_sharp


@helper
def _torques(tree, masses, path, most):
    """Computes the torques of three motions at each node but the last.

    The motions are: at rest; at rest with dv/dt = 1; and with v = 1.

    Returns:
        The torques, shape (k, 3, n_q) [N m, N], and their bounds, shape
        (n_arm,) [N m, N]. The bound of a motor is at least the torque that the
        motor needs at rest.
    """
    q, s = path
    k, n = len(q) - 1, q.shape[1]
    rate = np.empty((k, n))
    for i in range(k):
        for j in range(n):
            rate[i, j] = (q[i + 1, j] - q[i, j]) / (s[i + 1] - s[i])
    _, bend, _ = _turns(rate, s)
    v, a = np.zeros((k, 3, n)), np.zeros((k, 3, n))
    for i in range(k):
        for j in range(n):
            v[i, 2, j] = a[i, 1, j] = rate[i, j]
            a[i, 2, j] = bend[i, j]
    torque = inverse_dynamics(tree, masses, q[:k], v, a)
    limit, first = np.empty(len(most)), n - len(most)
    for c in range(len(most)):
        limit[c] = _SHARE * most[c]
        for i in range(k):
            limit[c] = max(limit[c], abs(torque[i, 0, first + c]))
    return torque, limit
