"""One step of a rollout in one compiled call: ask, decide, verify, move."""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.controller.braking import next_on_ramp, stopping_times
from remosplat_drake.controller.kernels.assemble import Parts, assemble
from remosplat_drake.controller.kernels.decide import decide
from remosplat_drake.controller.kernels.tick_arrays import (
    NearQuestion,
    given_or,
    near_arrays,
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
from remosplat_drake.controller.verification.self_sweep import OwnArrays
from remosplat_drake.controller.verification.verify import SCALES, TOLERANCE
from remosplat_drake.robot.kinematics import advance
from remosplat_drake.robot.robot_arrays import state_arrays
from remosplat_drake.scene.kernels.mover_reach import moved_on
from remosplat_drake.signals.compiled_map import IN_PLACE, find_rows

FORESIGHT = 2.0
"""For how long rollouts let what moves keep its twist; it rests then [s]."""


class LoopArrays(NamedTuple):
    """A law, as kernels take it that run its whole loop.

    Attributes:
        parts: Its ingredients.
        dt: Control period [s].
        strict: Whether every command keeps to the acceleration bounds.
        influence: Influence distance of the scene [m].
        stopping: Stopping distance from the scene [m].
        verify: Whether commands are verified.
        verify_own: Whether verification looks at the robot's own shapes, too.
        near: What is asked of `near_arrays`.
        own: `SelfClearance.arrays`.
        own_stopping: The distance that its pairs keep [m].
        separation: The distance that is kept from where movers can be [m].
    """

    parts: Parts
    dt: float
    strict: bool
    influence: float
    stopping: float
    verify: bool
    verify_own: bool
    near: NearQuestion
    own: OwnArrays
    own_stopping: float
    separation: float


@kernel
def rollout_step(
    law, robot, maps, compiled, movers, ahead, aim, q, u_previous, guidance
):
    """Simulates one step, as `run_tick` decides it.

    Args:
        law: The `LoopArrays`.
        robot: The `RobotArrays`.
        maps: The map, as `DistanceField.compiled_rows`.
        compiled: The map, as `DistanceField.compiled`.
        movers: The `MoverArrays` at the rollout's start.
        ahead: Time since the start [s].
        aim: The `AimArrays`.
        q: Configuration, shape (n_q,) [rad, m].
        u_previous: The command that is being executed, shape (n_u,).
        guidance: The `GuidanceArrays`.

    Returns:
        The command, shape (n_u,), the configuration after it, shape (n_q,),
        the end effectors' poses there, shape (e, 4, 4), and whether all that is
        decided: if not, it must be found another way.
    """
    state = state_arrays(robot, q)
    rows = _rows(maps, robot, state.p_WS, law.influence)
    movers = moved_on(movers, ahead, FORESIGHT)
    program = assemble(
        law.parts,
        robot,
        state,
        aim,
        rows,
        movers,
        near_arrays(law.near, state.X_WL),
        u_previous,
        law.dt,
        np.zeros(len(robot.radius)),
        guidance,
    )
    u, decided = decide(program, robot, u_previous, law.dt, law.strict)
    if law.verify:
        clearance = np.full(len(robot.radius), law.influence)
        for row in range(len(rows[0])):
            i = rows[0][row]
            clearance[i] = min(clearance[i], rows[1][row])
        stopping = given_or(guidance.stopping, law.stopping)
        given = robot, compiled, movers, state, clearance, stopping
        u = _verified(law, given, u, u_previous)
    q_next = advance(q, u, robot.n_base, law.dt)
    return u, q_next, state_arrays(robot, q_next).X_WE, decided


@helper
def _rows(maps, robot, p_WS, influence):
    """The clearances within the influence distance, sphere by sphere."""
    n = len(p_WS)
    question = np.empty((n, 5))
    for i in range(n):
        for c in range(3):
            question[i, c] = p_WS[i, c]
        question[i, 3] = robot.radius[i] + influence
        question[i, 4] = robot.ignore_below[i]
    return find_rows(maps, question, robot.radius, influence)[:3]


@helper
def _verified(law, given, u, u_previous):
    """The command that may be applied; see `verification/verify.py`."""
    robot, compiled, movers, state, clearance, stopping = given
    own, level = law.own, np.minimum(stopping, clearance)
    brake = next_on_ramp(u_previous, robot.acceleration_limit, law.dt)
    for scale in SCALES:
        command = u if scale == 1.0 else brake + scale * (u - brake)
        path = (
            state.q.reshape(1, -1),
            command.copy().reshape(1, -1),
            np.zeros(1),
            robot.n_base,
            stopping_times(command, robot.acceleration_limit, law.dt),
        )
        lower, upper = robot.position_lower, robot.position_upper
        if not keeps_joint_limits(path, lower, upper):
            continue
        if law.verify_own:
            kept = np.full(len(own.rate), law.own_stopping)
            if not pairs_keep_apart(robot.tree, path, own, kept, TOLERANCE):
                continue
        clock = law.dt * np.arange(1.0, len(path[4]) + 1.0)
        if not keeps_off_movers(
            robot,
            path,
            clock,
            movers,
            state.p_WS,
            law.separation,
            np.zeros(len(robot.radius)),
            TOLERANCE,
        ):
            continue
        if sweeps_clear(
            robot,
            path,
            compiled,
            IN_PLACE,
            state.p_WS,
            clearance,
            level,
            TOLERANCE,
        ):
            return command
    return brake
