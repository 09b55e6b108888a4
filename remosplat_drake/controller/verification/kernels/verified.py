"""Verify-then-scale in one compiled call, for a robot that obeys at once.

It says what `verify.verified_command` does of a map that kernels can ask.
"""

import numpy as np

from remosplat_drake.base.kernels import helper
from remosplat_drake.controller.braking import next_on_ramp, stopping_times
from remosplat_drake.controller.verification.kernels.map_sweep import (
    keeps_joint_limits,
    sweeps_clear,
)
from remosplat_drake.controller.verification.kernels.mover_sweep import (
    keeps_off_movers,
)
from remosplat_drake.controller.verification.kernels.pair_sweep import (
    pairs_keep_apart,
)
from remosplat_drake.signals.binding import (
    COLLISION,
    JOINT_LIMIT,
    MOVER,
    SELF_COLLISION,
)

SCALES = (1.0, 0.5, 0.25, 0.125, 0.0625, 0.03125)
"""Fractions of the way from braking to the command that are tried."""

TOLERANCE = 5e-4
"""How far distances may fall below their level between the ends of ticks [m].

Without it a sphere that glides along an obstacle at its stopping distance
could never be shown to keep it.
"""

OBJECTIONS = ("", JOINT_LIMIT, SELF_COLLISION, MOVER, COLLISION)
"""What may stand against a command, in the order in which it is looked for."""

_NOTHING, _JOINTS, _ITSELF, _MOVERS, _SCENE = range(len(OBJECTIONS))


@helper
def verified(law, around, u, u_previous):
    """Finds the command closest to u, towards braking, that may be applied.

    Args:
        law: The `LoopArrays`.
        around: The `RobotArrays`; the map, as `DistanceField.compiled`, which
            is 1-Lipschitz, and its `Misplacement`; the `MoverArrays`; the
            `StateArrays`; present clearances of the spheres, or lower bounds of
            them that are at least the stopping distance, shape (n,) [m]; and
            that distance [m].
        u: The wanted command, shape (n_u,).
        u_previous: The command that is being executed, shape (n_u,).

    Returns:
        The command that may be applied, shape (n_u,), its fraction, and the
        number of what stood against the whole of u in `OBJECTIONS`.
    """
    limit = around[0].acceleration_limit
    brake = next_on_ramp(u_previous, limit, law.dt)
    first = _NOTHING
    for scale in SCALES:
        command = u if scale == 1.0 else brake + scale * (u - brake)
        found = _objection(law, around, command)
        if found == _NOTHING:
            return command, scale, first
        if first == _NOTHING:
            first = found
    return brake, 0.0, first


@helper
def _objection(law, around, u):
    """What the path of a command, or of its ramp, comes too near to."""
    robot, compiled, off, movers, state, clearance, stopping = around
    path = (
        state.q.reshape(1, -1),
        u.copy().reshape(1, -1),
        np.zeros(1),
        robot.n_base,
        stopping_times(u, robot.acceleration_limit, law.dt),
    )
    lower, upper = robot.position_lower, robot.position_upper
    if not keeps_joint_limits(path, lower, upper):
        return _JOINTS
    if law.verify_own:
        own = law.own
        kept = np.full(len(own.rate), law.own_stopping)
        if not pairs_keep_apart(robot.tree, path, own, kept, TOLERANCE):
            return _ITSELF
    if not keeps_off_movers(
        robot,
        path,
        law.dt * np.arange(1.0, len(path[4]) + 1.0),
        movers,
        state.p_WS,
        law.separation,
        np.zeros(len(robot.radius)),
        TOLERANCE,
    ):
        return _MOVERS
    if not sweeps_clear(
        robot,
        path,
        compiled,
        off,
        state.p_WS,
        clearance,
        np.minimum(stopping, clearance),
        TOLERANCE,
    ):
        return _SCENE
    return _NOTHING


@helper
def least_clearances(sphere, distance, n, most):
    """Returns the smallest clearance of each sphere, shape (n,) [m].

    Args:
        sphere: The sphere of each row, shape (m,).
        distance: The rows' clearances, shape (m,) [m].
        n: Number of spheres.
        most: What a sphere has without a nearer row [m].
    """
    least = np.full(n, most)
    for row in range(len(sphere)):
        i = sphere[row]
        least[i] = min(least[i], distance[row])
    return least
