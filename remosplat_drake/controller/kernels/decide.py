"""What a tick decides, by kernels alone; see `controller/decision.py`."""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.controller.active_set import OPTIMAL, UNDECIDED
from remosplat_drake.controller.braking import next_on_ramp
from remosplat_drake.controller.kernels.assemble import YIELDING
from remosplat_drake.controller.kernels.dense import prune, solve_program
from remosplat_drake.signals.tick_report import STATUSES

NOT_DECIDED = -1
"""Where rounding leaves the solver undecided: another one must be asked."""

_WHOLE, _DROPPED, _RELAXED, BRAKING = range(len(STATUSES))


@kernel
def decide(program, robot, u_previous, dt, strict):
    """Solves the program of a tick, falling back where it has no optimum.

    Args:
        program: The `ProgramArrays`; falling back changes them.
        robot: The `RobotArrays`.
        u_previous: The command that is being executed, shape (n_u,).
        dt: Control period [s].
        strict: Whether every command keeps to the acceleration bounds.

    Returns:
        The command, shape (n_u,), and the number of its status in
        `tick_report.STATUSES`, or NOT_DECIDED.
    """
    u, ended = solve_program(program)
    if _is_answer(u, ended):
        return u, _status(ended, _WHOLE)
    if program.count[2] and not strict:
        for j in range(len(u)):
            program.lower[j] = program.free_lower[j]
            program.upper[j] = program.free_upper[j]
        prune(program)
        u, ended = solve_program(program)
        if _is_answer(u, ended):
            return u, _status(ended, _DROPPED)
    for k in YIELDING:
        if not _raise_to_zero(program, k):
            continue
        prune(program)
        u, ended = solve_program(program)
        if _is_answer(u, ended):
            return u, _status(ended, _RELAXED)
    ramp = next_on_ramp(u_previous, robot.acceleration_limit, dt)
    return ramp, BRAKING


@helper
def _is_answer(u, ended):
    return ended == UNDECIDED or (ended == OPTIMAL and np.isfinite(u).all())


@helper
def _status(ended, status):
    return NOT_DECIDED if ended == UNDECIDED else status


@helper
def _raise_to_zero(program, k):
    """Raises negative right-hand sides of ingredient k, if there are any."""
    is_raised = False
    for i in range(program.rows[k, 0], program.rows[k, 1]):
        if program.b[i] < 0.0:
            program.b[i] = 0.0
            program.raised[i] = is_raised = True
    return is_raised
