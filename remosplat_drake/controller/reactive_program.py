"""The quadratic program of one tick: built, solved, and when it fails.

Decision variables are the command u and the slack delta of the end-effector
twist (paper section III-A); what is minimised and what must hold comes from
the ingredients, one small class each.
"""

import dataclasses as dc
from collections.abc import Sequence
from typing import Protocol

import numpy as np
from pydrake.solvers import MathematicalProgram, SolverInterface

from remosplat_drake.controller import tick_report
from remosplat_drake.controller.servo import PoseError
from remosplat_drake.oracle.distance_field import Clearances
from remosplat_drake.robot.robot_model import RobotModel, RobotState
from remosplat_drake.safety.braking import braking_command


@dc.dataclass(frozen=True, eq=False)
class Tick:
    """All that one tick knows.

    Attributes:
        robot: Limits and kinematics.
        state: Kinematics at the measured configuration.
        X_WT: Target pose, shape (4, 4).
        error: From the end effector to the target.
        clearances: Distances within the influence distance.
        u_previous: The command that is being executed, shape (n_u,).
        dt: Control period [s].
    """

    robot: RobotModel
    state: RobotState
    X_WT: np.ndarray
    error: PoseError
    clearances: Clearances
    u_previous: np.ndarray
    dt: float

    @property
    def error_scale(self) -> float:
        """The paper's e, kept from vanishing at the target [m]."""
        return max(self.error.distance_l1, 1e-3)


@dc.dataclass(frozen=True, eq=False)
class Rows:
    """Inequality rows A u <= b of one ingredient, all of them.

    Attributes:
        A: Shape (m, n_u).
        b: Shape (m,).
        labels: What each row is about, length m.
        kept: The rows that are in the program, shape (m,) bool; the velocity
            limits imply the others.
    """

    A: np.ndarray
    b: np.ndarray
    labels: Sequence[str]
    kept: np.ndarray


class Ingredient(Protocol):
    """A cost or constraint of the program."""

    def AddToProgram(self, program: "ReactiveProgram", tick: Tick) -> None:
        """Adds what the ingredient stands for, described by its name."""
        ...


class ReactiveProgram:
    """A `MathematicalProgram` in u (n_u) and the slack delta (6).

    Attributes:
        prog: Drake's program.
        u: Decision variables of the command.
        delta: Slack of the end-effector twist (angular, translational).
        rows: Inequality rows by ingredient name.
        use_acceleration: Whether acceleration bounds are wanted.
        relax: Whether negative right-hand sides are raised to zero, so that
            u = 0 is feasible.
    """

    def __init__(
        self,
        velocity_limit: np.ndarray,
        *,
        use_acceleration: bool = True,
        relax: bool = False,
    ):
        self.prog = MathematicalProgram()
        self.u = self.prog.NewContinuousVariables(len(velocity_limit), "u")
        self.delta = self.prog.NewContinuousVariables(6, "delta")
        self.rows: dict[str, Rows] = {}
        self.use_acceleration = use_acceleration
        self.relax = relax
        self.has_acceleration_bounds = False
        self.yielded: list[str] = []
        self._velocity_limit = velocity_limit

    def add_rows(
        self, name: str, A: np.ndarray, b: np.ndarray, labels: Sequence[str]
    ):
        """Adds A u <= b, less the rows that cannot bind.

        A row whose largest value within the velocity limits,
        sum_j |A_ij| limit_j, does not exceed b_i is redundant: leaving it
        out changes nothing but the solver's time.
        """
        if self.relax:
            negative = np.flatnonzero(b < 0)
            self.yielded += [f"{name}[{labels[i]}]" for i in negative]
            b = np.maximum(b, 0.0)
        kept = np.abs(A) @ self._velocity_limit > b
        self.rows[name] = Rows(A, b, labels, kept)
        if kept.any():
            self.prog.AddLinearConstraint(
                A[kept], np.full(kept.sum(), -np.inf), b[kept], self.u
            ).evaluator().set_description(name)


def build_program(
    tick: Tick,
    ingredients: Sequence[Ingredient],
    *,
    use_acceleration: bool = True,
    relax: bool = False,
) -> ReactiveProgram:
    """Builds the program of one tick afresh.

    Args:
        tick: What is known.
        ingredients: Costs and constraints, in any order.
        use_acceleration: See `ReactiveProgram`.
        relax: See `ReactiveProgram`.
    """
    program = ReactiveProgram(
        tick.robot.velocity_limit,
        use_acceleration=use_acceleration,
        relax=relax,
    )
    for ingredient in ingredients:
        ingredient.AddToProgram(program, tick)
    return program


def solve(
    program: ReactiveProgram, solver: SolverInterface
) -> np.ndarray | None:
    """The optimal command, shape (n_u,), or None without a finite optimum."""
    result = solver.Solve(program.prog, None, None)  # pyright: ignore
    if not result.is_success():
        return None
    u = result.GetSolution(program.u)
    return u if np.isfinite(u).all() else None


@dc.dataclass(frozen=True, eq=False)
class Decision:
    """A command, how it came about, and the program behind it."""

    u: np.ndarray
    status: str
    reason: str
    program: ReactiveProgram


def decide(
    tick: Tick,
    ingredients: Sequence[Ingredient],
    solver: SolverInterface,
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
    u = braking_command(tick.u_previous, tick.robot.acceleration_limit, tick.dt)
    return Decision(
        u, tick_report.BRAKING, "no feasible command found", program
    )
