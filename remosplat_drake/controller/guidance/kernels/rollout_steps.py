"""Steps of a rollout in one compiled call: ask, decide, verify, move."""

import numpy as np

from remosplat_drake.base.kernels import kernel
from remosplat_drake.controller.kernels.decide import NOT_DECIDED
from remosplat_drake.controller.kernels.settle import settle
from remosplat_drake.robot.kinematics import advance
from remosplat_drake.robot.robot_arrays import state_arrays
from remosplat_drake.scene.kernels.mover_reach import aged, moved_on
from remosplat_drake.signals.compiled_map import IN_PLACE, clearance_rows

FORESIGHT = 2.0
"""For how long rollouts let what moves keep its twist; it rests then [s]."""


@kernel
def rollout_steps(
    law,
    robot,
    maps,
    compiled,
    movers,
    age,
    ahead,
    aim,
    q,
    u_previous,
    guidance,
    steps,
):
    """Simulates some steps, each as `run_tick` decides it.

    Args:
        law: The `LoopArrays`.
        robot: The `RobotArrays`.
        maps: The map, as `DistanceField.compiled_rows`.
        compiled: The map, as `DistanceField.compiled`.
        movers: The `MoverArrays`.
        age: How old what is known of them is at the rollout's start [s].
        ahead: Time since the start [s].
        aim: The `AimArrays`.
        q: Configuration, shape (n_q,) [rad, m].
        u_previous: The command that is being executed, shape (n_u,).
        guidance: The `GuidanceArrays`.
        steps: Number of steps.

    Returns:
        Of each step the command, shape (s, n_u), the configuration after it,
        shape (s, n_q), and the end effectors' poses there, shape (s, e, 4, 4).
        There are fewer than asked for where one cannot be decided: it must be
        found another way.
    """
    around = aged(movers, age)
    us = np.empty((steps, len(u_previous)))
    qs = np.empty((steps, len(q)))
    state = state_arrays(robot, q)
    X_WEs = np.empty((steps, *state.X_WE.shape))
    u = u_previous
    for k in range(steps):
        sphere, distance, direction_W, _, is_defined = clearance_rows(
            maps, state.p_WS, robot.radius, robot.ignore_below, law.influence
        )
        rows = sphere, distance, direction_W
        later = moved_on(around, ahead, FORESIGHT)
        given = robot, compiled, IN_PLACE, state, rows, later
        _, _, status, verdict = settle(law, given, aim, u, guidance)
        if not is_defined or status == NOT_DECIDED:
            return us[:k], qs[:k], X_WEs[:k]
        u = verdict[0]
        q = advance(q, u, robot.n_base, law.dt)
        state = state_arrays(robot, q)
        us[k], qs[k], X_WEs[k] = u, q, state.X_WE
        ahead += law.dt
    return us, qs, X_WEs
