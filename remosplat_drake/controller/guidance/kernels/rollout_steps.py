"""Simulates steps of a rollout: query of the map, tick, and motion."""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.controller.prediction.kernels.lead_forward import (
    PIECES,
    led,
)
from remosplat_drake.controller.program.kernels.tick_arrays import given_or
from remosplat_drake.controller.tick.kernels.settle import (
    settle,
    what_is_unknown,
)
from remosplat_drake.robot.actuator_response import respond
from remosplat_drake.robot.braking import next_on_ramp
from remosplat_drake.robot.kinematics import advance
from remosplat_drake.robot.robot_arrays import state_arrays
from remosplat_drake.scene.kernels.mover_reach import aged, moved_on
from remosplat_drake.scene.mover import FORESIGHT
from remosplat_drake.signals.motion import MotionArrays
from remosplat_drake.signals.rows_within import rows_within


@kernel
def rollout_steps(
    law,
    robot,
    maps,
    compiled,
    off,
    movers,
    age,
    motion,
    now,
    ahead,
    aim,
    q,
    u_previous,
    guidance,
    steps,
    line,
):
    """Simulates steps of a rollout, each with the robot's control tick.

    Args:
        law: The `LawArrays`.
        robot: The `RobotArrays`.
        maps: The map, in the form that `rows_within` takes.
        compiled: The map, in the form that `sphere_clearances` takes.
        off: The map's `Misplacement`.
        movers: The `MoverArrays`.
        age: Age of the movers' measurements at the rollout's start [s].
        motion: The `MotionArrays` at this step.
        now: The time of the rollout's start [s].
        ahead: Time since the rollout's start [s].
        aim: The `AimArrays`.
        q: Configuration, shape (n_q,) [rad, m]. For a robot with delay, it is
            the configuration after all commands that have been sent.
        u_previous: The command that is being executed, shape (n_u,).
        guidance: The `GuidanceArrays`.
        steps: Number of steps.
        line: Number of the `PythonCalls`.

    Returns:
        For each step, the command, shape (s, n_u), the configuration after the
        step, shape (s, n_q), and the poses of the end effectors in this
        configuration, shape (s, e, 4, 4). After the last step, the fields
        `sent` to `q_start` of the `MotionArrays`.
    """
    around = aged(movers, age)
    us = np.empty((steps, len(u_previous)))
    qs = np.empty((steps, len(q)))
    stopping = given_or(guidance.stopping, law.stopping)
    state = state_arrays(robot, q)
    X_WEs = np.empty((steps, *state.X_WE.shape))
    u, moving = u_previous, _unpacked(motion)
    for k in range(steps):
        rows = rows_within(maps, line, robot, state, law.influence, stopping)
        later = moved_on(around, ahead, FORESIGHT)
        given = robot, (compiled, off, line), state, rows, later, moving
        is_known = what_is_unknown(q, rows, aim) == 0
        ramp = next_on_ramp(u, robot.acceleration_limit, law.dt)
        _, _, _, verdict, _ = settle(
            law, given, now + ahead, ahead, aim, is_known, u, ramp, guidance
        )
        u = verdict[0]
        q = advance(q, u, robot.n_base, law.dt)
        state = state_arrays(robot, q)
        us[k], qs[k], X_WEs[k] = u, q, state.X_WE
        moving = _motion_after(moving, u, law.dt, robot.n_base)
        ahead += law.dt
    # The arrays are copied, since the arrays of a motion may be memory of this
    # kernel.
    after = (
        moving.sent.copy(),
        moving.u.copy(),
        moving.time,
        moving.start,
        moving.v_start.copy(),
        moving.q_start.copy(),
    )
    return us, qs, X_WEs, after


@helper
def _unpacked(motion):
    return MotionArrays(
        motion.is_late,
        motion.parameters,
        motion.tube,
        motion.sent,
        motion.u,
        motion.time,
        motion.start,
        motion.v_start,
        motion.q_start,
    )


@helper
def _motion_after(motion, u, dt, n_base):
    """Returns the motion of a robot one period after it received a command.

    Args:
        motion: The `MotionArrays` when the command is sent.
        u: The command, shape (n_u,).
        dt: The period [s].
        n_base: Number of base commands.
    """
    if not motion.is_late:
        return motion
    n, longest = len(u), 0.0
    for j in range(n):
        longest = max(longest, motion.parameters[j, 0])
    # Commands before this one no longer have an effect.
    first = max(np.searchsorted(motion.sent, motion.start - longest) - 1, 0)
    h = len(motion.sent) - first
    sent, told = np.empty(h + 1), np.empty((h + 1, n))
    for i in range(h + 1):
        sent[i] = motion.sent[first + i] if i < h else motion.time
        for j in range(n):
            told[i, j] = motion.u[first + i, j] if i < h else u[j]
    until = np.empty((PIECES, n))
    for k in range(PIECES):
        for j in range(n):
            until[k, j] = motion.start + dt * (k + 1) / PIECES
    way, v = respond(
        motion.parameters,
        sent,
        told,
        np.full(n, motion.start),
        motion.v_start,
        until,
    )
    for k in range(PIECES - 1, 0, -1):
        for j in range(n):
            way[k, j] -= way[k - 1, j]
    return MotionArrays(
        motion.is_late,
        motion.parameters,
        motion.tube,
        sent,
        told,
        motion.time + dt,
        motion.start + dt,
        v[PIECES - 1].copy(),
        led(motion.q_start, way, n_base),
    )
