"""Checks that configurations, and motions between them, keep distances.

A motion is checked like a command in verification: between two samples,
distances may be smaller than required by verification's tolerance. See
`map_looks.py` and `self_looks.py`.
"""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import TRUTH
from remosplat_drake.controller.planning.kernels.map_looks import (
    is_off_the_map,
    keeps_off_the_map,
)
from remosplat_drake.controller.planning.kernels.self_looks import (
    is_off_itself,
    keeps_off_itself,
)
from remosplat_drake.controller.planning.steering import (
    stretch_command,
    waypoints,
)
from remosplat_drake.controller.verification.kernels.between_looks import (
    TOLERANCE,
)
from remosplat_drake.controller.verification.kernels.mover_sweep import (
    keeps_off_movers,
)
from remosplat_drake.controller.verification.kernels.places import held
from remosplat_drake.robot.kinematics import (
    advance,
    body_poses,
    sphere_points,
)
from remosplat_drake.scene.kernels.mover_reach import near_movers

_LOOK = 0.8
"""Motion of a sphere between two samples of the first round [m]."""

_MOST_PLACES = 8
"""Largest number of equal parts of a motion. The configurations between these
parts are checked before the whole motion: of the blocked motions of a search
that end at a free configuration, nine in ten are blocked at one of these."""

_LEAST_PLACE = 0.3
"""Length of a motion below which only its end is checked beforehand, in radians
and metres alike: short motions that are blocked are mostly blocked at their
end."""

_MOVER_LOOK = 0.02
"""Motion of a sphere between two samples for standing movers [m]."""


@kernel(returns=TRUTH)
def is_free(space, line, q):
    """Returns whether a configuration keeps all distances.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of its map.
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
        line: Number of the `PythonCalls` of its map.
        a: A free configuration to start from, shape (n_q,) [rad, m].
        b: Configuration to end at, shape (n_q,) [rad, m].
    """
    # Most blocked motions end in collision.
    return is_free(space, line, b) and moves_freely(space, line, a, b)


@kernel(returns=TRUTH)
def moves_freely(space, line, a, b):
    """Returns whether the motion between two free configurations is free.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of its map.
        a: Configuration to start from, shape (n_q,) [rad, m].
        b: Configuration to end at, shape (n_q,) [rad, m].
    """
    n_base = space.robot.n_base
    corners = waypoints(a, b, n_base, space.backing)
    if not _is_off_at_places(space, line, corners):
        return False
    for k in range(len(corners) - 1):
        u = stretch_command(corners[k], corners[k + 1], n_base)
        if not _keeps_off_scene(space, line, corners[k], u):
            return False
    return keeps_off_itself(space, a, _arms_command(a, b, n_base))


@helper
def _is_off_at_places(space, line, corners):
    """Returns whether samples of a motion are free of the map, coarse first."""
    square, parts = 0.0, 2
    for j in range(corners.shape[1]):
        square += (corners[-1, j] - corners[0, j]) ** 2
    while parts <= _MOST_PLACES and square > (parts * _LEAST_PLACE) ** 2:
        for k in range(1, parts, 2):
            if not _is_off_there(space, line, corners, k / parts):
                return False
        parts *= 2
    return True


@helper
def _is_off_there(space, line, corners, share):
    """Returns whether a motion is free of the map at a fraction of it."""
    n_base, last = space.robot.n_base, len(corners) - 2
    k = min(int(share * (last + 1)), last)
    u = stretch_command(corners[k], corners[k + 1], n_base)
    q = advance(corners[k], u, n_base, share * (last + 1) - k)
    X_WL, _ = body_poses(space.robot.tree, q)
    return is_off_the_map(space, line, X_WL)


@helper
def _arms_command(a, b, n_base):
    """Returns the command of only the arms, which move uniformly."""
    first = 3 if n_base else 0
    u = np.zeros(n_base + len(a) - first)
    for j in range(first, len(a)):
        u[n_base + j - first] = b[j] - a[j]
    return u


@helper
def _keeps_off_scene(space, line, q, u):
    """Returns whether a motion with one held command is free of the scene.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of its map.
        q: A free configuration, at which it starts, shape (n_q,) [rad, m].
        u: The command, which is held for a second, shape (n_u,).
    """
    robot, travel = space.robot, 0.0
    for i in range(len(robot.radius)):
        way = 0.0
        for j in range(len(u)):
            way += robot.jacobian_bound[i, j] * abs(u[j])
        travel = max(travel, way)
    looks = max(1, round(travel / _LOOK))
    return keeps_off_the_map(space, line, q, u, looks) and _keeps_off_movers(
        space, q, u, travel
    )


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
def _keeps_off_movers(space, q, u, travel):
    """Returns whether a motion keeps its distances from standing movers."""
    movers, robot = space.movers, space.robot
    if len(movers.radius) == 0:
        return True
    looks = max(1, round(travel / _MOVER_LOOK))
    times = np.empty(looks)
    for k in range(looks):
        times[k] = (k + 1.0) / looks
    X_WL, _ = body_poses(robot.tree, q)
    p_WS, _ = sphere_points(X_WL, robot.body_S, robot.p_LS)
    path = held(q, u, robot.n_base, times, times)
    tube = np.zeros(len(p_WS))
    return keeps_off_movers(robot, path, movers, p_WS, 0.0, tube, TOLERANCE)
