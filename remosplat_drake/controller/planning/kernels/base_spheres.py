"""Checks the spheres that move only with the base.

Most random poses of a base collide. The base and the parts that are fixed to it
are one rigid body, so their spheres are placed without the kinematics of the
arms. The sphere that collided last is checked first, since it often collides
again.
"""

import math
from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import TRUTH, named, reals, wholes
from remosplat_drake.robot.kinematics import body_poses
from remosplat_drake.signals.compiled_map import sphere_clearances

_ROUNDING = 1e-9
"""Bound of rounding errors of distances [m]."""


class BaseSpheres(NamedTuple):
    """The m spheres that move only with the base.

    Attributes:
        order: Order in which the spheres are checked, shape (m,). Kernels
            change it.
        sphere: Indices of the spheres, shape (m,).
        p_BS: Centres of the spheres in the base's frame, shape (m, 3) [m]. The
            frame's origin is on the ground, and x points forward.
        R_BL: Orientations of the spheres' links in the base's frame, shape (m,
            3, 3).
        reach: Clearances that the spheres must keep, shape (m,) [m].
    """

    order: np.ndarray
    sphere: np.ndarray
    p_BS: np.ndarray
    R_BL: np.ndarray
    reach: np.ndarray


@kernel(
    returns=named(
        BaseSpheres, wholes(1), wholes(1), reals(2), reals(3), reals(1)
    )
)
def base_spheres(space):
    """Finds the spheres that move only with the base.

    Args:
        space: The `SpaceArrays`.
    """
    robot = space.robot
    n = len(robot.radius) if robot.n_base > 0 else 0
    sphere, m = np.empty(n, np.int64), 0
    for i in range(n):
        if not _is_moved_by_arm(robot, robot.body_S[i]):
            sphere[m], m = i, m + 1
    sphere = sphere[:m].copy()
    X_BL, _ = body_poses(robot.tree, np.zeros(len(space.lower)))
    p_BS, R_BL, reach = np.zeros((m, 3)), np.empty((m, 3, 3)), np.empty(m)
    for k in range(m):
        i = sphere[k]
        X = X_BL[robot.body_S[i]]
        reach[k] = space.level[i]
        for r in range(3):
            p_BS[k, r] = X[r, 3]
            for c in range(3):
                R_BL[k, r, c] = X[r, c]
                p_BS[k, r] += X[r, c] * robot.p_LS[i, c]
    return BaseSpheres(np.arange(m), sphere, p_BS, R_BL, reach)


@helper
def _is_moved_by_arm(robot, body):
    """Returns whether a joint of an arm moves a body."""
    is_moved = False
    for j in range(robot.n_base, robot.moves.shape[1]):
        is_moved |= robot.moves[body, j]
    return is_moved


@kernel(returns=TRUTH)
def may_stand(space, line, base, q):
    """Returns whether the base's spheres are free of collisions at a pose.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of the map.
        base: The `BaseSpheres`.
        q: Configuration, shape (n_q,). Only the base's pose is used.
    """
    m = len(base.order)
    if m == 0:
        return True
    sphere, reach, found = np.empty(m, np.int64), np.empty(m), np.empty(m)
    p_WS, R_WL = np.empty((m, 3)), np.empty((m, 3, 3))
    turn = math.cos(q[2]), math.sin(q[2])
    first = 0
    for last in (1, m):
        for k in range(first, last):
            i = base.order[k]
            sphere[k], reach[k] = base.sphere[i], base.reach[i]
            _turn(turn, base.p_BS[i], p_WS[k])
            p_WS[k, 0], p_WS[k, 1] = p_WS[k, 0] + q[0], p_WS[k, 1] + q[1]
            for j in range(3):
                _turn(turn, base.R_BL[i, :, j], R_WL[k, :, j])
        rows = slice(first, last)
        sphere_clearances(
            (space.map, space.off, line),
            space.robot,
            sphere[rows],
            p_WS[rows],
            R_WL[rows],
            reach[rows],
            found[rows],
        )
        for k in range(first, last):
            if not found[k] >= reach[k] - _ROUNDING:
                order = base.order
                order[0], order[k] = order[k], order[0]
                return False
        first = last
    return True


@helper
def _turn(turn, v, turned):
    """Rotates a vector about z, given cosine and sine; writes the result."""
    c, s = turn
    turned[0] = c * v[0] - s * v[1]
    turned[1] = s * v[0] + c * v[1]
    turned[2] = v[2]
