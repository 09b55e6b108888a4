"""The quadratic program of one tick: built, solved, and when it fails.

Decision variables are the command u and the slack delta of the end-effector
twist (paper section III-A); what is minimised and what must hold comes from
the ingredients, one small class each.
"""

import dataclasses as dc
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Protocol

import numpy as np
from pydrake.solvers import MathematicalProgram, SolverInterface

from remosplat_drake.controller import tick_report
from remosplat_drake.controller.guidance.guidance import DIRECT, Guidance
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
        guidance: How the tick is bent.
    """

    robot: RobotModel
    state: RobotState
    X_WT: np.ndarray
    error: PoseError
    clearances: Clearances
    u_previous: np.ndarray
    dt: float
    guidance: Guidance = DIRECT

    @property
    def error_scale(self) -> float:
        """The paper's e, kept from vanishing at the target [m]."""
        return max(self.error.distance_l1, 1e-3)

    @cached_property
    def approach_rates(self) -> np.ndarray:
        """Rows J_d = n' Jv_WS of all clearances, shape (m, n_u).

        J_d u is the rate at which a clearance shrinks (paper eq. 16).
        """
        clearances = self.clearances
        return np.einsum(
            "mi,mij->mj",
            clearances.direction_W,
            self.state.Jv_WS[clearances.sphere],
        )


@dc.dataclass(frozen=True, eq=False)
class Rows:
    """Inequality rows A u <= b of one ingredient, all of them.

    Attributes:
        A: Shape (m, n_u).
        b: Shape (m,).
        kept: The rows that are in the program, shape (m,) bool; the bounds
            on u imply the others.
    """

    A: np.ndarray
    b: np.ndarray
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
        x: All decision variables, u then delta.
        u: Decision variables of the command.
        delta: Slack of the end-effector twist (angular, translational).
        lower: Bounds on u, shape (n_u,); ingredients may only narrow them.
        upper: See `lower`.
        rows: Inequality rows by ingredient name.
        use_acceleration: Whether acceleration bounds are wanted.
        has_acceleration_bounds: Whether there are any.
        relax: Whether negative right-hand sides are raised to zero, so that
            u = 0 is feasible.
        yielded: Names of the rows that were raised.
    """

    def __init__(
        self,
        velocity_limit: np.ndarray,
        *,
        use_acceleration: bool = True,
        relax: bool = False,
    ):
        n_u = len(velocity_limit)
        self.prog = MathematicalProgram()
        self.x = self.prog.NewContinuousVariables(n_u + 6, "x")
        self.u, self.delta = self.x[:n_u], self.x[n_u:]
        self.lower, self.upper = -velocity_limit, velocity_limit
        self.rows: dict[str, Rows] = {}
        self.use_acceleration = use_acceleration
        self.has_acceleration_bounds = False
        self.relax = relax
        self.yielded: list[str] = []

    def narrow(self, lower: np.ndarray, upper: np.ndarray):
        """Bounds u by lower <= u <= upper, besides the present bounds."""
        self.lower = np.maximum(self.lower, lower)
        self.upper = np.minimum(self.upper, upper)

    def add_rows(
        self,
        name: str,
        A: np.ndarray,
        b: np.ndarray,
        label: Callable[[int], str],
    ):
        """Adds the rows A u <= b of the ingredient called `name`.

        `label(i)` says what row i is about; asked only when it must yield.

        Raises:
            ValueError: Another ingredient has added rows of that name.
        """
        if name in self.rows:
            raise ValueError(f"there are rows called {name!r} already")
        if self.relax:
            negative = np.flatnonzero(b < 0)
            self.yielded += [f"{name}[{label(int(i))}]" for i in negative]
            b = np.maximum(b, 0.0)
        self.rows[name] = Rows(A, b, np.ones(len(b), bool))

    def finish(self):
        """Puts bounds and rows into `prog`, less the rows that cannot bind.

        A row whose largest value within the bounds of u does not exceed b_i
        is redundant: leaving it out changes nothing but the solver's time.
        """
        self.prog.AddBoundingBoxConstraint(
            self.lower, self.upper, self.u
        ).evaluator().set_description("command bounds")
        center = 0.5 * (self.upper + self.lower)
        radius = 0.5 * (self.upper - self.lower)
        for name, rows in self.rows.items():
            largest = rows.A @ center + np.abs(rows.A) @ radius
            kept = largest > rows.b
            self.rows[name] = dc.replace(rows, kept=kept)
            if kept.any():
                b = rows.b[kept]
                self.prog.AddLinearConstraint(
                    rows.A[kept], np.full(len(b), -np.inf), b, self.u
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
    program.finish()
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
    """A command, how it came about, and the program behind it, if any."""

    u: np.ndarray
    status: str
    reason: str
    program: ReactiveProgram | None = None


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
    return brake(
        tick.robot, tick.u_previous, tick.dt, "no feasible command found"
    )


def brake(
    robot: RobotModel, u_previous: np.ndarray, dt: float, reason: str
) -> Decision:
    """The next step of the ramp to a standstill."""
    u = braking_command(u_previous, robot.acceleration_limit, dt)
    return Decision(u, tick_report.BRAKING, reason)
