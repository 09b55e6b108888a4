"""What a tick decides: its program solved, and what to do when it fails."""

import dataclasses as dc
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from remosplat_drake.controller.braking import braking_command
from remosplat_drake.controller.reactive_program import (
    Ingredient,
    ReactiveProgram,
    Tick,
    build_program,
)
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals import tick_report


class Solver(Protocol):
    """Finds the optimum of a program."""

    def solve(self, program: ReactiveProgram) -> np.ndarray | None:
        """The optimal command, shape (n_u,), or None if there is none."""
        ...


def solve(program: ReactiveProgram, solver: Solver) -> np.ndarray | None:
    """The optimal command, shape (n_u,), or None without a finite optimum."""
    u = solver.solve(program)
    return u if u is not None and np.isfinite(u).all() else None


@dc.dataclass(frozen=True, eq=False)
class Decision:
    """A command, how it came about, and the program behind it, if any."""

    u: np.ndarray
    status: str
    reason: str
    program: ReactiveProgram | None = None


def decide(
    tick: Tick,
    ingredients: Sequence[Ingredient],
    solver: Solver,
    program: ReactiveProgram | None = None,
) -> Decision:
    """Solves the tick's program, falling back in the named order.

    As it stands; without acceleration bounds; with negative right-hand sides
    raised to zero; and last a braking ramp. A fallback never goes unnamed.

    Args:
        tick: What is known.
        ingredients: Costs and constraints.
        solver: A convex QP solver.
        program: The program as it stands, if the caller has built it.
    """
    program = program or build_program(tick, ingredients)
    u = solve(program, solver)
    if u is not None:
        return Decision(u, tick_report.OPTIMAL, "", program)
    if program.has_acceleration_bounds:
        program = build_program(tick, ingredients, use_acceleration=False)
        u = solve(program, solver)
        if u is not None:
            return Decision(
                u,
                tick_report.ACCELERATION_DROPPED,
                "infeasible with acceleration bounds",
                program,
            )
    program = build_program(
        tick, ingredients, use_acceleration=False, relax=True
    )
    u = solve(program, solver)
    if u is not None:
        reason = "infeasible; yielded: " + (
            ", ".join(program.yielded) or "nothing"
        )
        return Decision(u, tick_report.RELAXED, reason, program)
    return brake(
        tick.robot, tick.u_previous, tick.dt, "no feasible command found"
    )


def brake(
    robot: RobotModel, u_previous: np.ndarray, dt: float, reason: str
) -> Decision:
    """The next step of the ramp to a standstill."""
    u = braking_command(u_previous, robot.acceleration_limit, dt)
    return Decision(u, tick_report.BRAKING, reason)
