"""Computes the costs of goal configurations."""

import math

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import reals
from remosplat_drake.controller.planning.kernels.inverse_kinematics import (
    least_manipulability,
)
from remosplat_drake.controller.planning.kernels.map_checks import (
    sphere_margins,
)

_ENOUGH = 0.06
"""A goal's cost decreases with its least clearance, until this clearance
exceeds the required one by this value [m]."""

_CRAMPED, _AT_LIMIT, _SINGULAR = 0.02, 0.2, 0.02
"""Decrease of a clearance [m], of a distance from a joint limit [rad, m], and
of the manipulability, by which a part of the cost increases e-fold."""


@kernel(returns=reals(1))
def goal_costs(space, line, arms, goals, q):
    """Computes goals' costs, which increase far away and near obstacles.

    The cost is roughly the time to reach the goal [s]. It is larger if the goal
    is near obstacles, joint limits or a singularity.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of the map.
        arms: The `Arms`.
        goals: The goal configurations, shape (k, n_q) [rad, m].
        q: Present configuration, shape (n_q,) [rad, m].

    Returns:
        The costs, shape (k,).
    """
    margins = sphere_margins(space, line, goals, _ENOUGH)
    manipulability = least_manipulability(arms, goals)
    cost = np.empty(len(goals))
    for k in range(len(goals)):
        margin, inside = np.inf, np.inf
        for i in range(margins.shape[1]):
            margin = min(margin, margins[k, i])
        for j in range(arms.first, len(q)):
            above = goals[k, j] - space.lower[j]
            below = space.upper[j] - goals[k, j]
            inside = min(inside, min(above, below))
        cost[k] = (
            _time(space, arms.first, goals[k], q)
            + 2.0 * math.exp(-margin / _CRAMPED)
            + math.exp(-inside / _AT_LIMIT)
            + math.exp(-manipulability[k] / _SINGULAR)
        )
    return cost


@helper
def _time(space, first, goal, q):
    """Returns the least duration of a motion to a goal [s]."""
    robot, time = space.robot, 0.0
    for j in range(first, len(q)):
        speed = robot.velocity_limit[robot.n_base + j - first]
        time = max(time, abs(goal[j] - q[j]) / speed)
    if robot.n_base > 0:
        way = math.hypot(goal[0] - q[0], goal[1] - q[1])
        time = max(time, way / robot.velocity_limit[0])
    return time
