"""Computes the greatest speeds on a path that the collision damper permits."""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import reals
from remosplat_drake.base.lanes import WIDTH
from remosplat_drake.controller.planning.kernels.map_checks import query_margins
from remosplat_drake.controller.verification.kernels.between_samples import (
    apart,
)
from remosplat_drake.robot.pose_lanes import place_bodies, place_by_lanes
from remosplat_drake.signals.compiled_map import is_compiled, is_lipschitz

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
    n, (q, s), (slope, stopping, creep) = len(space.level), path, law
    speed, knows_between = fastest.copy(), is_lipschitz(space.map)
    short = stopping - space.level
    p_WS, R_WL = np.empty((n, 3)), np.empty((n, 3, 3))
    p_next, R_next = np.empty((n, 3)), np.empty((n, 3, 3))
    margin, margin_before = np.full(n, -np.inf), np.full(n, -np.inf)
    wanted, wanted_before = np.zeros(n), np.zeros(n)
    placed, way = np.empty((n, 3, WIDTH)), np.zeros(n)
    _place_spheres(space, q, 0, placed, p_next, R_next)
    for k in range(len(q)):
        p_WS, p_next, R_WL, R_next = p_next, p_WS, R_next, R_WL
        wanted_before, wanted = wanted, wanted_before
        wanted[:] = 0.0
        if k < len(speed):
            _place_spheres(space, q, k + 1, placed, p_next, R_next)
            for i in range(n):
                way[i] = apart(p_WS[i], p_next[i])
            if speed[k] > creep:
                longest = speed[k] / (slope * (s[k + 1] - s[k]))
                for i in range(n):
                    wanted[i] = min(longest * way[i], _FAR) + short[i]
        _update_margins(
            space, line, (p_WS, R_WL), wanted, wanted_before, margin
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
                margin[i] -= way[i]
            else:
                margin[i] = -np.inf
    return speed


@helper
def _place_spheres(space, q, k, placed, p_WS, R_WL):
    """Places the spheres at a node, and at each eighth node at eight nodes.

    Args:
        space: The `SpaceArrays`.
        q: The nodes, shape (m, n_q) [rad, m].
        k: Index of the node. Nodes are placed in the order of the path.
        placed: Memory for the spheres at eight nodes, shape (n, 3, 8).
        p_WS: Output: the centres at the node, shape (n, 3) [m].
        R_WL: Output: the orientations of their links, shape (n, 3, 3). Only
            maps in Python use them.
    """
    robot, samples, lane = space.robot, space.samples, k % WIDTH
    if lane == 0:
        for node in range(WIDTH):
            for j in range(q.shape[1]):
                samples.q[j, node] = q[min(k + node, len(q) - 1), j]
        place_bodies(robot.tree, samples.q, samples.X_WL, samples.scratch)
        place_by_lanes(samples.X_WL, robot.body_S, robot.p_LS, placed)
    for i in range(len(p_WS)):
        for r in range(3):
            p_WS[i, r] = placed[i, r, lane]
            if not is_compiled(space.map):
                for c in range(3):
                    R_WL[i, r, c] = samples.X_WL[robot.body_S[i], r, c, lane]


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
