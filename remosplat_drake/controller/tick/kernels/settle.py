"""Computes a whole control tick: program, decision and verification.

Simulations, rollouts and real robots use the same functions.
"""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import WHOLE, reals, several
from remosplat_drake.base.python_calls import call_python
from remosplat_drake.controller.ingredients import CollisionDamper
from remosplat_drake.controller.ingredients.kernels.assemble import (
    PARTS,
    Parts,
    assemble,
)
from remosplat_drake.controller.program.kernels.binding_arrays import (
    binding_arrays,
)
from remosplat_drake.controller.program.kernels.compiled_terms import NO_PART
from remosplat_drake.controller.program.kernels.outside import add_outside
from remosplat_drake.controller.program.kernels.tick_arrays import (
    PROGRAM,
    NearSettings,
    OutsideRows,
    given_or,
    make_program,
)
from remosplat_drake.controller.tick.kernels.decide import (
    BRAKING,
    decide,
    demanded_retreat,
    least_retreat,
    nearest_inside,
    should_retreat,
)
from remosplat_drake.controller.verification.kernels.verified import (
    NOTHING,
    VERDICT,
    KeptArrays,
    least_clearances,
    sphere_tube,
    surroundings,
    verified,
)
from remosplat_drake.robot.braking import held_command, next_on_ramp
from remosplat_drake.robot.robot_arrays import state_arrays
from remosplat_drake.scene.kernels.mover_reach import aged
from remosplat_drake.signals.compiled_map import are_known

UNKNOWN = (
    "",
    "measured configuration is not finite",
    "clearances are not finite",
    "target is not finite",
)
"""Reasons, as text, for braking because an input of the tick is unknown."""

REFUSE = 4
"""Index of the Python function that formats the error about a compiled
ingredient's terms."""

SCENE = PARTS.index(CollisionDamper)
"""Number of the ingredient whose rows correspond to clearances."""


class LawArrays(NamedTuple):
    """A control law, packed for kernels.

    Attributes:
        parts: The compiled ingredients.
        has_outside: Whether there are ingredients in Python.
        outside: Empty `OutsideRows`, from which Numba infers the type of their
            rows.
        is_own_solver: Whether the library's own solver is used.
        dt: Control period [s].
        strict: Whether every command must keep the acceleration bounds.
        influence: Influence distance of the scene [m].
        stopping: Stopping distance from the scene [m].
        verify: Whether commands are verified.
        near: Settings of the search for near links.
        kept: Settings of verification.
    """

    parts: Parts
    has_outside: bool
    outside: OutsideRows
    is_own_solver: bool
    dt: float
    strict: bool
    influence: float
    stopping: float
    verify: bool
    near: NearSettings
    kept: KeptArrays


class Settled(NamedTuple):
    """The results of a tick; see `TickReport`.

    Attributes:
        command: The command that may be applied, shape (n_u,).
        status: Index of the command's status in `tick_report.STATUSES`.
        scale: `TickReport.scale`.
        objection: Index of the objection in `verified.OBJECTIONS`.
        kept: `TickReport.kept`.
        tight: `TickReport.tight`.
        binding: The result of `binding_arrays`.
        yielded: Number of the ingredient and subject of each relaxed row, shape
            (y, 2).
        inside: The result of `nearest_inside`.
        unknown: Index in `UNKNOWN` of the unknown input.
    """

    command: np.ndarray
    status: int
    scale: float
    objection: int
    kept: np.ndarray
    tight: np.ndarray
    binding: tuple[np.ndarray, np.ndarray, np.ndarray]
    yielded: np.ndarray
    inside: tuple[int, int, int]
    unknown: int


@kernel
def settle_tick(
    law,
    robot,
    compiled,
    off,
    movers,
    age,
    motion,
    now,
    aim,
    rows,
    q,
    u_previous,
    periods,
    guidance,
    line,
):
    """Computes a tick; see `run_tick`.

    Args:
        law: The `LawArrays`.
        robot: The `RobotArrays`.
        compiled: The map: `DistanceField.compiled` if that is 1-Lipschitz, or
            else a `PythonMap`.
        off: The map's `Misplacement`.
        movers: The `MoverArrays`.
        age: Age of the movers' measurements [s].
        motion: The `MotionArrays`.
        now: The time of the tick [s].
        aim: The `AimArrays`.
        rows: The `RowArrays` of the clearances.
        q: Configuration, shape (n_q,) [rad, m].
        u_previous: The command that was sent last, shape (n_u,).
        periods: Number of control periods since that command was sent.
        guidance: The `GuidanceArrays`.
        line: Number of the `PythonCalls`.

    Returns:
        The values of `Settled`.
    """
    state = state_arrays(robot, q)
    given = robot, (compiled, off, line), state, rows, aged(movers, age), motion
    unknown = what_is_unknown(q, rows, aim)
    limit, elapsed = robot.acceleration_limit, periods * law.dt
    executed = held_command(u_previous, limit, law.dt, elapsed)
    ramp = next_on_ramp(u_previous, limit, elapsed)
    program, u, status, verdict, inside = settle(
        law, given, now, 0.0, aim, unknown == 0, executed, ramp, guidance
    )
    command, scale, objection = verdict
    kept, tight = np.zeros((2, len(rows.sphere)), np.bool_)
    if status != BRAKING:
        first, last = program.rows[SCENE]
        for i in range(first, last):
            kept[i - first] = program.kept[i]
        binding = binding_arrays(program, u)
        for part, index, _ in binding[0]:
            if part == SCENE:
                tight[index] = True
    else:
        binding = np.empty((0, 3), np.int64), np.empty((0, 0)), np.empty(0)
    return (
        command,
        status,
        scale,
        objection,
        kept,
        tight,
        binding,
        _yielded(program),
        inside,
        unknown,
    )


@helper
def what_is_unknown(q, rows, aim) -> int:
    """Returns the index in `UNKNOWN` of the unknown input of a tick.

    Args:
        q: Configuration, shape (n_q,) [rad, m].
        rows: The `RowArrays` of the clearances.
        aim: The `AimArrays`.
    """
    if not np.isfinite(q).all():
        return 1
    if not are_known(rows):
        return 2
    if not (np.isfinite(aim.X_WT).all() and np.isfinite(aim.X_WA).all()):
        return 3
    return 0


_INSIDE = several(WHOLE, WHOLE, WHOLE)
"""Numba's type of the result of `nearest_inside`."""


@kernel(returns=several(PROGRAM, reals(1), WHOLE, VERDICT, _INSIDE))
def settle(law, given, now, ahead, aim, is_known, u_previous, ramp, guidance):
    """Builds the program of a tick, decides, and verifies the decision.

    Args:
        law: The `LawArrays`.
        given: A tuple of the `RobotArrays`; a tuple of the map, its
            `Misplacement` and the number of the `PythonCalls`; the
            `StateArrays`; the `RowArrays` of the clearances; the `MoverArrays`
            at their present age; and the `MotionArrays`.
        now: The time of the tick [s].
        ahead: Time since the start of the rollout [s].
        aim: The `AimArrays`.
        is_known: Whether all inputs are known. If not, the robot brakes.
        u_previous: The command that is being executed, shape (n_u,).
        ramp: The braking ramp's next step, shape (n_u,).
        guidance: The `GuidanceArrays`.

    Returns:
        The `ProgramArrays`; the result of `decide`; and, as two tuples, the
        results of `verified` and of `nearest_inside`.
    """
    robot, placed, state, rows, movers, motion = given
    if is_known:
        program, is_known = _whole_program(
            law, given, ahead, aim, u_previous, guidance
        )
    else:
        program = make_program(robot.velocity_limit, 0, 1, 0)
    if not is_known:
        return program, ramp, BRAKING, (ramp, 1.0, NOTHING), (NO_PART, 0, 0)
    inside, retreat = nearest_inside(program), demanded_retreat(program)
    u, status = decide(program, ramp, law.strict, law.is_own_solver, placed[2])
    if not law.verify:
        return program, u, status, (u, 1.0, NOTHING), inside
    around = surroundings(
        robot,
        placed,
        movers,
        motion,
        now,
        state,
        least_clearances(
            rows.sphere, rows.distance, len(robot.radius), law.influence
        ),
        given_or(guidance.stopping, law.stopping),
        u,
        u_previous,
    )
    verdict = verified(law.kept, around, u, ramp)
    if status != BRAKING and should_retreat(verdict[1], retreat):
        out, is_found = least_retreat(program, law.is_own_solver, placed[2])
        if is_found:
            command, scale, _ = verified(law.kept, around, out, ramp)
            if scale > verdict[1]:
                verdict = command, scale, verdict[2]
                return program, out, status, verdict, inside
    return program, u, status, verdict, inside


@helper
def _whole_program(law, given, ahead, aim, u_previous, guidance):
    """Builds the program of all ingredients.

    Returns:
        The `ProgramArrays`, and whether all terms are valid.
    """
    robot, placed, state, rows, movers, motion = given
    program, refused, ended = assemble(
        law.parts,
        robot,
        state,
        aim,
        (rows.sphere, rows.distance, rows.direction_W),
        movers,
        law.near,
        u_previous,
        law.dt,
        sphere_tube(robot, motion.tube, u_previous),
        guidance,
    )
    if refused != NO_PART:
        call_python(placed[2], REFUSE, (program, refused, ended))
        return make_program(robot.velocity_limit, 0, 1, 0), False
    if not law.has_outside:
        return program, True
    inputs = state, u_previous, rows, ahead
    return add_outside(law.outside, placed[2], program, inputs)


@helper
def _yielded(program):
    """Finds the relaxed rows of each ingredient."""
    found, count = np.empty((program.count[0], 2), np.int64), 0
    for part in range(len(program.rows)):
        for i in range(program.rows[part, 0], program.rows[part, 1]):
            if program.raised[i]:
                found[count, 0], found[count, 1] = part, program.about[i]
                count += 1
    return found[:count]
