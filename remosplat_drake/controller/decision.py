"""What a tick decides: its program solved, and what to do when it fails."""

import dataclasses as dc
from collections.abc import Iterator, Sequence
from typing import Protocol

import numpy as np

from remosplat_drake.controller.braking import braking_command
from remosplat_drake.controller.law_program import LawProgram
from remosplat_drake.controller.reactive_program import ReactiveProgram
from remosplat_drake.controller.tick import Tick
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals import tick_report
from remosplat_drake.signals.binding import (
    JOINT_LIMIT,
    MOVER,
    SELF_COLLISION,
)

YIELD_ORDER = (MOVER, JOINT_LIMIT, SELF_COLLISION)
"""Names of the rows that yield first in an infeasible program, in this order.

Those before the scene, and of ingredients of one's own, come last. Costs yield
to all rows, and verification to nothing.
"""


TOO_SUDDEN = "infeasible with acceleration bounds"
"""Why acceleration bounds are left out."""

NOT_FEASIBLE = "no feasible command found"
"""Why the robot brakes where not even that helps."""


class Solver(Protocol):
    """Finds the optimum of the convex quadratic program of a tick."""

    def solve(self, program: ReactiveProgram) -> np.ndarray | None:
        """Finds the optimal command u, shape (n_u,); None if there is none.

        Args:
            program: The finished program of a tick.
        """
        ...


def solve(program: ReactiveProgram, solver: Solver) -> np.ndarray | None:
    """Finds the optimal command, shape (n_u,); None without a finite optimum.

    Args:
        program: The finished program of a tick.
        solver: The convex solver to ask.
    """
    if program.is_hopeless:
        return None
    u = solver.solve(program)
    return u if u is not None and np.isfinite(u).all() else None


@dc.dataclass(frozen=True, eq=False)
class Decision:
    """A command, how it came about, and the program behind it.

    Attributes:
        u: The command, shape (n_u,) [rad/s, m/s].
        status: OPTIMAL, ACCELERATION_DROPPED, RELAXED or BRAKING, as in
            `signals.tick_report`.
        reason: Why it is not the optimum of the whole program, in words;
            empty with OPTIMAL.
        program: The program whose optimum u is; None with BRAKING.
    """

    u: np.ndarray
    status: str
    reason: str
    program: ReactiveProgram | None = None


def decide(
    tick: Tick, program: LawProgram, solver: Solver, *, strict: bool = False
) -> Decision:
    """Solves the program of a tick, falling back where it has no optimum.

    The program is tried as it stands, then without acceleration bounds, then
    with negative right-hand sides of its rows raised to zero as well, in
    `YIELD_ORDER`: first those before what moves, then those before joint
    limits, then those before the robot itself, and then those before the scene
    and of ingredients of one's own. Last comes a step of the braking ramp. A
    fallback never goes unnamed. Where the law is strict,
    acceleration bounds are never left out. Verification, and with it the joint
    limits themselves, yields to nothing.

    Args:
        tick: What is known at the tick: the robot's state, the target, the
            clearances and the command being executed.
        program: The program as it stands.
        solver: The convex solver to ask.
        strict: Whether every command keeps to the acceleration bounds.

    Raises:
        TermError: A program with less demanded cannot be built; see
            `LawProgram.weakened`, as of the others.
        NameTakenError: See above.
        IngredientError: See above.
    """
    whole = program
    u = solve(program, solver)
    if u is not None:
        return Decision(u, tick_report.OPTIMAL, "", program)
    if program.has_acceleration_bounds and not strict:
        program = whole.weakened(use_acceleration=False)
        u = solve(program, solver)
        if u is not None:
            return Decision(
                u, tick_report.ACCELERATION_DROPPED, TOO_SUDDEN, program
            )
    for names in _yielding(program):
        program = whole.weakened(use_acceleration=strict, relax=names)
        u = solve(program, solver)
        if u is not None:
            reason = yielding_reason(program.yielded)
            return Decision(u, tick_report.RELAXED, reason, program)
    return brake(tick.robot, tick.u_previous, tick.dt, NOT_FEASIBLE)


def yielding_reason(names: Sequence[str]) -> str:
    """Says which rows had to yield.

    Args:
        names: The rows, as `program_data.row_name` names them.
    """
    return f"infeasible; yielded: {', '.join(names)}"


def _yielding(program: ReactiveProgram) -> Iterator[frozenset[str]]:
    """Yields the sets of rows that may yield together, fewest first.

    Only rows that demand a retreat can make standing still infeasible.
    """
    retreats = {
        name for name, rows in program.rows.items() if (rows.b < 0.0).any()
    }
    dampers = [{name} for name in YIELD_ORDER]
    names: set[str] = set()
    for more in (*dampers, retreats.difference(*dampers)):
        if more & retreats:
            names |= more
            yield frozenset(names)


def brake(
    robot: RobotModel, u_previous: np.ndarray, dt: float, reason: str
) -> Decision:
    """Decides for the next step of the braking ramp to a standstill.

    Args:
        robot: The robot, for its acceleration limits.
        u_previous: The command being executed, shape (n_u,).
        dt: Control period [s].
        reason: Why the robot brakes, in words.
    """
    u = braking_command(u_previous, robot.acceleration_limit, dt)
    return Decision(u, tick_report.BRAKING, reason)
