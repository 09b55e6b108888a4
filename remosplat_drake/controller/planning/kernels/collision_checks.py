"""Checks that configurations and motions keep all distances.

A motion is checked like a command in verification: between two samples,
distances may be smaller than required by the tolerance of verification; see
`map_motion.py` and `self_motion.py`.
"""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import TRUTH, WHOLE
from remosplat_drake.controller.planning.kernels.map_checks import (
    is_off_the_map,
)
from remosplat_drake.controller.planning.kernels.map_motion import (
    keeps_off_the_map,
)
from remosplat_drake.controller.planning.kernels.self_checks import (
    is_off_itself,
)
from remosplat_drake.controller.planning.kernels.self_motion import (
    keeps_off_itself,
)
from remosplat_drake.controller.planning.steering import (
    segment_command,
    waypoints,
)
from remosplat_drake.controller.verification.kernels.between_samples import (
    TOLERANCE,
)
from remosplat_drake.controller.verification.kernels.mover_sweep import (
    keeps_off_movers,
)
from remosplat_drake.controller.verification.kernels.places import held
from remosplat_drake.robot.kinematics import (
    body_poses,
    sphere_points,
)
from remosplat_drake.scene.kernels.mover_reach import near_movers

_MOVER_STEP = 0.02
"""Largest motion of a sphere between two samples at which its distances from
standing movers are checked [m]."""


@kernel(returns=TRUTH)
def is_free(space, line, q):
    """Returns whether a configuration keeps all distances.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of the map.
        q: The configuration, shape (n_q,) [rad, m].
    """
    if not _is_within(space, q):
        return False
    X_WL, _ = body_poses(space.robot.tree, q)
    return (
        is_off_the_map(space, line, X_WL)
        and _is_off_movers(space, X_WL)
        and is_off_itself(space, X_WL)
    )


@helper
def _is_within(space, q):
    """Returns whether all joints are within their bounds."""
    inside = True
    for j in range(len(q)):
        inside &= space.lower[j] <= q[j] <= space.upper[j]
    return inside


@kernel(returns=TRUTH)
def is_free_between(space, line, a, b):
    """Returns whether the whole motion between two configurations is free.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of the map.
        a: Configuration at the start, which is free, shape (n_q,) [rad, m].
        b: Configuration at the end, shape (n_q,) [rad, m].
    """
    # The end is checked first, since most blocked motions end in collision.
    return is_free(space, line, b) and moves_freely(space, line, a, b)


@kernel(returns=TRUTH)
def moves_freely(space, line, a, b):
    """Returns whether the motion between two free configurations is free.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of the map.
        a: Configuration at the start, shape (n_q,) [rad, m].
        b: Configuration at the end, shape (n_q,) [rad, m].
    """
    n_base = space.robot.n_base
    corners = waypoints(a, b, n_base, space.backing)
    for k in range(len(corners) - 1):
        u = segment_command(corners[k], corners[k + 1], n_base)
        if not (
            keeps_off_the_map(space, line, corners[k], u)
            and _keeps_off_movers(space, corners[k], u)
        ):
            return False
    return keeps_off_itself(space, a, _arms_command(a, b, n_base))


@kernel(returns=WHOLE)
def first_reached(space, line, q, goals):
    """Returns the index of the first goal that a single free motion reaches.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of the map.
        q: Configuration at the start, which is free, shape (n_q,) [rad, m].
        goals: Configurations at the end, shape (k, n_q) [rad, m].

    Returns:
        The index; k if no motion is free.
    """
    for k in range(len(goals)):
        if is_free_between(space, line, q, goals[k]):
            return k
    return len(goals)


@helper
def _arms_command(a, b, n_base):
    """Returns the command of only the arms, which move uniformly."""
    first = 3 if n_base else 0
    u = np.zeros(n_base + len(a) - first)
    for j in range(first, len(a)):
        u[n_base + j - first] = b[j] - a[j]
    return u


@helper
def _is_off_movers(space, X_WL):
    """Returns whether spheres keep their distances from standing movers."""
    movers, robot = space.movers, space.robot
    if len(movers.radius) == 0:
        return True
    p_WS, _ = sphere_points(X_WL, robot.body_S, robot.p_LS)
    near = near_movers(movers, p_WS, robot.radius, 1e-9, 0.0)
    for row in range(len(near.sphere)):
        if near.distance[row] < space.mover_level[near.sphere[row]]:
            return False
    return True


@helper
def _keeps_off_movers(space, q, u):
    """Returns whether a motion keeps its distances from standing movers.

    Args:
        space: The `SpaceArrays`.
        q: Configuration at the start of the motion, which is free, shape (n_q,)
            [rad, m].
        u: The command, which is held for a second, shape (n_u,).
    """
    movers, robot, travel = space.movers, space.robot, 0.0
    if len(movers.radius) == 0:
        return True
    for i in range(len(robot.radius)):
        way = 0.0
        for j in range(len(u)):
            way += robot.jacobian_bound[i, j] * abs(u[j])
        travel = max(travel, way)
    samples = max(1, round(travel / _MOVER_STEP))
    times = np.empty(samples)
    for k in range(samples):
        times[k] = (k + 1.0) / samples
    X_WL, _ = body_poses(robot.tree, q)
    p_WS, _ = sphere_points(X_WL, robot.body_S, robot.p_LS)
    path = held(q, u, robot.n_base, times, times)
    tube = np.zeros(len(p_WS))
    return keeps_off_movers(robot, path, movers, p_WS, 0.0, tube, TOLERANCE)
