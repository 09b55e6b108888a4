"""Verify-then-scale: scales a command until the path of its braking is free.

`verify.py` states and proves the guarantee.
"""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import REAL, WHOLE, reals, several
from remosplat_drake.controller.verification.kernels.between_samples import (
    TOLERANCE,
    tolerated,
)
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
from remosplat_drake.controller.verification.kernels.stopping import (
    in_flight,
    stopping_path,
)
from remosplat_drake.robot.robot_arrays import state_arrays
from remosplat_drake.robot.self_collision.pair_arrays import PairArrays
from remosplat_drake.scene.kernels.mover_reach import aged
from remosplat_drake.signals.binding import (
    COLLISION,
    JOINT_LIMIT,
    MOVER,
    SELF_COLLISION,
)
from remosplat_drake.signals.compiled_map import sphere_clearances

SCALES = (1.0, 0.5, 0.25, 0.125, 0.0625, 0.03125)
"""Fractions between braking (0) and the command (1) that are tried."""

OBJECTIONS = ("", JOINT_LIMIT, SELF_COLLISION, MOVER, COLLISION)
"""Possible reasons to reject a command, in the order of the checks."""

NOTHING, _JOINTS, _ITSELF, _MOVERS, _SCENE = range(len(OBJECTIONS))


VERDICT = several(reals(1), REAL, WHOLE)
"""Numba's type of the result of `verified`."""


class SelfCollisionArrays(NamedTuple):
    """The arrays of a `SelfClearance`, packed for kernels.

    Attributes:
        pairs: The pairs of shapes.
        rate: `SelfClearance.rate`.
        lever: `SelfClearance.lever`.
        turns: Whether each command is that of a revolute joint, shape (n_u,),
            bool.
    """

    pairs: PairArrays
    rate: np.ndarray
    lever: np.ndarray
    turns: np.ndarray


class KeptArrays(NamedTuple):
    """The settings of verification, which are the same at each tick.

    Attributes:
        dt: Duration of a tick [s].
        spare: Time for which a station holds a command after the end of its
            tick [s].
        checks_self_collision: Whether self-collision is checked.
        self_pairs: The pairs of the robot's own shapes.
        self_stopping: Stopping distance of these pairs [m].
        separation: The distance to keep from all possible positions of movers
            [m].
    """

    dt: float
    spare: float
    checks_self_collision: bool
    self_pairs: SelfCollisionArrays
    self_stopping: float
    separation: float


class Around(NamedTuple):
    """The known state and distances at the start of a path.

    Attributes:
        robot: The `RobotArrays`.
        placed: The map, in the form that `sphere_clearances` takes.
        movers: The `MoverArrays`, with the age of the measurements at the
            path's start.
        motion: The `MotionArrays`.
        q: Configuration, shape (n_q,) [rad, m].
        p_WS: Centres of the n spheres in W, shape (n, 3) [m].
        clearance: Clearances of the spheres, or lower bounds that are at least
            the stopping distance, shape (n,) [m].
        stopping: Stopping distance that spheres keep from the scene [m].
    """

    robot: tuple
    placed: tuple
    movers: tuple
    motion: tuple
    q: np.ndarray
    p_WS: np.ndarray
    clearance: np.ndarray
    stopping: float


@helper
def surroundings(
    robot, placed, movers, motion, now, state, clearance, stopping, u, before
):
    """Returns the state and the distances at which a command begins to act.

    Clearances are known in the configuration for which the tick computes its
    command. A robot with delay reaches this configuration later than the
    command begins to act. If a sphere is at the distance x from its position in
    this configuration, its clearance is smaller by at most x. If this bound is
    not sufficient, the map is queried.

    Args:
        robot: See `Around`.
        placed: See `Around`.
        movers: The `MoverArrays`, with the present age of the measurements.
        motion: See `Around`.
        now: The time of the tick [s].
        state: The `StateArrays` for which the tick computes its command.
        clearance: Clearances of the spheres in `state`, or lower bounds that
            are at least the stopping distance, shape (n,) [m].
        stopping: See `Around`.
        u: The wanted command, shape (n_u,).
        before: The command that is being executed, shape (n_u,).

    Returns:
        The `Around`.
    """
    if not motion.is_late:
        return Around(
            robot,
            placed,
            aged(movers, movers.age),
            motion,
            state.q,
            state.p_WS,
            clearance,
            stopping,
        )
    start = state_arrays(robot, motion.q_start.copy())
    peak = in_flight(motion)
    for j in range(len(u)):
        peak[j] = max(peak[j], abs(u[j]), abs(before[j]))
    needed = stopping + sphere_tube(robot, motion.tube, peak)
    left, near, count = clearance.copy(), np.empty(len(needed), np.int64), 0
    reach = -np.inf
    for i in range(len(left)):
        moved = 0.0
        for c in range(3):
            moved += (start.p_WS[i, c] - state.p_WS[i, c]) ** 2
        left[i] -= np.sqrt(moved)
        if not left[i] >= needed[i]:
            near[count] = i
            reach = max(reach, needed[i])
            count += 1
    near = near[:count]
    found = np.empty(count)
    sphere_clearances(
        placed, robot, near, start.p_WS[near], start.R_WL[near], reach, found
    )
    for k in range(count):
        left[near[k]] = found[k]
    return Around(
        robot,
        placed,
        aged(movers, movers.age + motion.start - now),
        motion,
        start.q,
        start.p_WS,
        left,
        stopping,
    )


@helper
def sphere_tube(robot, tube, speed):
    """Returns bounds of spheres' deviations from a path, shape (n,) [m].

    Args:
        robot: The `RobotArrays`.
        tube: Bounds of position errors of the axes, divided by their speeds,
            shape (n_u,) [s].
        speed: Greatest speed of each axis, shape (n_u,).
    """
    bound = np.zeros(len(robot.radius))
    for i in range(len(bound)):
        for j in range(len(tube)):
            bound[i] += robot.jacobian_bound[i, j] * tube[j] * abs(speed[j])
    return bound


@kernel(returns=VERDICT)
def verified(kept, around, u, ramp):
    """Finds the largest verified command between braking and u.

    The function tries interpolations between the next step of the braking ramp
    (fraction 0) and u (fraction 1). All of them keep the acceleration bounds if
    u does. Fraction 0 needs no check, since the braking ramp was verified
    together with the previous command.

    Args:
        kept: The `KeptArrays`.
        around: The `Around`.
        u: The wanted command, shape (n_u,).
        ramp: The braking ramp's next step, shape (n_u,).

    Returns:
        The command that may be applied, shape (n_u,), its fraction, and the
        index in `OBJECTIONS` of the reason to reject u.
    """
    robot = around.robot
    first = NOTHING
    for scale in SCALES:
        command = u if scale == 1.0 else ramp + scale * (u - ramp)
        path = stopping_path(
            robot,
            around.motion,
            around.q,
            command.copy(),
            kept.dt,
            kept.spare,
        )
        found = path_objection(kept, around, path)
        if found == NOTHING:
            return command, scale, first
        if first == NOTHING:
            first = found
    return ramp, 0.0, first


@kernel(returns=WHOLE)
def path_objection(kept, around, path):
    """Returns the reason to reject a path, as an index in `OBJECTIONS`.

    A path is allowed if each sphere keeps at least the distance min(d_s, its
    present clearance) from the scene, if the robot's own shapes keep distances
    in the same way, and if each joint stays within its limits. At the ends of
    ticks there is no tolerance. Otherwise distances could decrease a little in
    each of many ticks. If the robot may deviate from the path, d_s is increased
    by the possible change of the distance.

    Args:
        kept: The `KeptArrays`.
        around: The `Around` at the path's start.
        path: The `PathArrays`.
    """
    robot, own = around.robot, kept.self_pairs
    lower, upper = robot.position_lower, robot.position_upper
    if not keeps_joint_limits(path, lower, upper):
        return _JOINTS
    if kept.checks_self_collision:
        off = np.zeros(len(own.rate))
        for k in range(len(off)):
            for j in range(len(path.peak)):
                off[k] += own.rate[k, j] * path.tube[j] * path.peak[j]
        if not pairs_keep_apart(robot.tree, path, own, kept.self_stopping, off):
            return _ITSELF
    tube, p_WS = sphere_tube(robot, path.tube, path.peak), around.p_WS
    if not keeps_off_movers(
        robot, path, around.movers, p_WS, kept.separation, tube, TOLERANCE
    ):
        return _MOVERS
    level = np.minimum(around.stopping + tube, around.clearance)
    tolerance = np.empty(len(level))
    for i in range(len(level)):
        tolerance[i] = tolerated(level[i], around.stopping)
    if not sweeps_clear(
        robot, path, around.placed, p_WS, around.clearance, level, tolerance
    ):
        return _SCENE
    return NOTHING


@helper
def least_clearances(sphere, distance, n, most):
    """Returns each sphere's smallest clearance, shape (n,) [m].

    Args:
        sphere: Index of the sphere of each row, shape (m,).
        distance: The rows' clearances, shape (m,) [m].
        n: Number of spheres.
        most: Clearance of a sphere without a nearer row [m].
    """
    least = np.full(n, most)
    for row in range(len(sphere)):
        i = sphere[row]
        least[i] = min(least[i], distance[row])
    return least
