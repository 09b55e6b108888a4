"""One step of a rollout in one compiled call: ask, decide, verify, move."""

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
def rollout_step(
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
):
    """Simulates one step, as `run_tick` decides it.

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

    Returns:
        The command, shape (n_u,), the configuration after it, shape (n_q,),
        the end effectors' poses there, shape (e, 4, 4), and whether all that is
        decided: if not, it must be found another way.
    """
    state = state_arrays(robot, q)
    sphere, distance, direction_W, _, is_defined = clearance_rows(
        maps, state.p_WS, robot.radius, robot.ignore_below, law.influence
    )
    rows = sphere, distance, direction_W
    later = moved_on(aged(movers, age), ahead, FORESIGHT)
    given = robot, compiled, IN_PLACE, state, rows, later
    _, _, status, verdict = settle(law, given, aim, u_previous, guidance)
    u = verdict[0]
    q_next = advance(q, u, robot.n_base, law.dt)
    X_WE = state_arrays(robot, q_next).X_WE
    return u, q_next, X_WE, is_defined and status != NOT_DECIDED
