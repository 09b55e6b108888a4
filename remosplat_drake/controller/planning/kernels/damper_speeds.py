"""Computes the greatest speeds on a path that the collision damper permits."""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import reals
from remosplat_drake.controller.planning.kernels.map_checks import query_margins
from remosplat_drake.controller.verification.kernels.between_samples import (
    apart,
)
from remosplat_drake.robot.kinematics import body_poses, place_points
from remosplat_drake.signals.compiled_map import is_lipschitz

_FAR = 0.2
"""Excess of a clearance over the stopping distance above which a sphere does
not limit the speed [m]."""

_AHEAD = 0.05
"""Distance by which queries reach farther than needed [m]. No other query is
needed until a sphere has moved by this distance."""


@kernel(returns=reals(1))
def damper_speeds(space, line, path, fastest, law):
    """Returns bounds of the speeds along a path, by the spheres' clearances.

    Let r be the excess of a sphere's clearance over the stopping distance. On a
    segment of length s, on which the excess decreases from r to r', the damper
    allows the speed v if v (r - r') / s <= c r, where c is the slope of its
    law.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of the map.
        path: The nodes, shape (k + 1, n_q) [rad, m], and the arc length to each
            node, shape (k + 1,).
        fastest: Bounds of the speeds by other limits, shape (k,) [1/s].
        law: The slope c [1/s], the stopping distance [m], and the speed below
            which spheres do not limit the motion [1/s].

    Returns:
        The bound of the speed on each piece, at most `fastest`, shape (k,)
        [1/s].
    """
    robot, n = space.robot, len(space.level)
    (q, s), (slope, stopping, creep) = path, law
    speed, knows_between = fastest.copy(), is_lipschitz(space.map)
    short = stopping - space.level
    p_before, R_before = np.empty((n, 3)), np.empty((n, 3, 3))
    p_WS, R_WL = np.empty((n, 3)), np.empty((n, 3, 3))
    margin, margin_before = np.full(n, -np.inf), np.full(n, -np.inf)
    wanted, wanted_before = np.zeros(n), np.zeros(n)
    X_WL, _ = body_poses(robot.tree, q[0])
    place_points(X_WL, robot.body_S, robot.p_LS, p_WS, R_WL)
    for k in range(len(q)):
        for i in range(n):
            wanted_before[i], wanted[i] = wanted[i], 0.0
            for c in range(3):
                p_before[i, c] = p_WS[i, c]
        R_before[:] = R_WL
        if k < len(speed):
            X_WL, _ = body_poses(robot.tree, q[k + 1])
            place_points(X_WL, robot.body_S, robot.p_LS, p_WS, R_WL)
            if speed[k] > creep:
                longest = speed[k] / (slope * (s[k + 1] - s[k]))
                for i in range(n):
                    way = apart(p_before[i], p_WS[i])
                    wanted[i] = min(longest * way, _FAR) + short[i]
        _update_margins(
            space, line, (p_before, R_before), wanted, wanted_before, margin
        )
        if k > 0:
            step = s[k] - s[k - 1]
            least = speed[k - 1]
            for i in range(n):
                nearer = margin_before[i] - margin[i]
                if margin_before[i] < wanted_before[i] and nearer > 0.0:
                    allowed = slope * (margin_before[i] - short[i]) * step
                    least = min(least, allowed / nearer)
            speed[k - 1] = max(least, min(speed[k - 1], creep))
        for i in range(n):
            margin_before[i] = margin[i]
            if knows_between:
                margin[i] -= apart(p_before[i], p_WS[i])
            else:
                margin[i] = -np.inf
    return speed


@helper
def _update_margins(space, line, at, wanted, wanted_before, margin):
    """Measures the margins whose lower bounds are smaller than needed."""
    n = len(margin)
    reach = np.empty(n)
    for i in range(n):
        most = max(wanted[i], wanted_before[i])
        # Spheres with sufficient lower bounds are not queried.
        reach[i] = -np.inf if margin[i] > most else most + _AHEAD
    query_margins(space, line, at, reach, margin, -np.inf)
