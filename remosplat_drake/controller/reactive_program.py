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
from pydrake.solvers import MathematicalProgram

from remosplat_drake.controller import tick_report
from remosplat_drake.controller.active_set import DenseProgram
from remosplat_drake.controller.drake_program import DrakeProgram, fill
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


class Solver(Protocol):
    """Finds the optimum of a program."""

    def solve(self, program: "ReactiveProgram") -> np.ndarray | None:
        """The optimal command, shape (n_u,), or None if there is none."""
        ...


class Ingredient(Protocol):
    """A cost or constraint of the program."""

    def AddToProgram(self, program: "ReactiveProgram", tick: Tick) -> None:
        """Adds what the ingredient stands for, described by its name."""
        ...


@dc.dataclass(frozen=True, eq=False)
class Tracking:
    """J u + delta = V with the cost |delta|^2 price / 2 and bounds on delta.

    Attributes:
        J: Jacobian of the end effector (angular, translational), (6, n_u).
        V: Wanted twist, shape (6,).
        price: Of the squared slack delta.
        limit: Bounds on |delta|, shape (6,).
    """

    J: np.ndarray
    V: np.ndarray
    price: float
    limit: np.ndarray


class ReactiveProgram:
    """A quadratic program in u (n_u) and the slack delta (6), as data.

    `prog` is the same as Drake's `MathematicalProgram`, `dense` as matrices
    in u alone. An ingredient may add to `prog` itself what the methods here
    do not express; then there is no `dense`.

    Attributes:
        lower: Bounds on u, shape (n_u,); ingredients may only narrow them.
        upper: See `lower`.
        rows: Inequality rows by ingredient name.
        linear: Linear costs c'u by ingredient name, shape (n_u,) each.
        quadratic: Diagonals W of costs u'Wu / 2, by ingredient name.
        tracking: Of the end effector's twist, if any.
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
        self.lower, self.upper = -velocity_limit, velocity_limit
        self.rows: dict[str, Rows] = {}
        self.linear: dict[str, np.ndarray] = {}
        self.quadratic: dict[str, np.ndarray] = {}
        self.tracking: Tracking | None = None
        self.use_acceleration = use_acceleration
        self.has_acceleration_bounds = False
        self.relax = relax
        self.yielded: list[str] = []
        self._drake: DrakeProgram | None = None
        self._is_finished = False

    @property
    def n_u(self) -> int:
        """Length of the command."""
        return len(self.lower)

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
        """Marks the rows that cannot bind, and ends the data's part.

        A row whose largest value within the bounds of u does not exceed b_i
        is redundant: leaving it out changes nothing but the solver's time.
        """
        for name, rows in self.rows.items():
            kept = self._can_bind(rows.A, rows.b)
            self.rows[name] = dc.replace(rows, kept=kept)
        self._is_finished = True
        if self._drake is not None:
            fill(self._drake, self)

    @property
    def prog(self) -> MathematicalProgram:
        """Drake's program."""
        return self.drake.prog

    @property
    def drake(self) -> "DrakeProgram":
        """Drake's program and its variables; made when first asked for."""
        if self._drake is None:
            self._drake = DrakeProgram(self.n_u, extended=not self._is_finished)
            if self._is_finished:
                fill(self._drake, self)
        return self._drake

    @property
    def u(self) -> np.ndarray:
        """Drake's decision variables of the command."""
        return self.drake.u

    @property
    def is_extended(self) -> bool:
        """Whether an ingredient has used `prog`; what, only Drake knows."""
        return self._drake is not None and self._drake.extended

    def dense(self) -> DenseProgram:
        """The program in u alone: the slack is V - J u."""
        tracking = self.tracking
        H, c = np.diag(sum(self.quadratic.values(), np.zeros(self.n_u))), 0.0
        c = sum(self.linear.values(), np.zeros(self.n_u))
        eye = np.eye(self.n_u)
        A = [eye, -eye, *(rows.A[rows.kept] for rows in self.rows.values())]
        b = [self.upper, -self.lower]
        b += [rows.b[rows.kept] for rows in self.rows.values()]
        if tracking is not None:
            J, V, limit = tracking.J, tracking.V, tracking.limit
            H += tracking.price * J.T @ J
            c = c - tracking.price * V @ J
            slack_A = np.concatenate([J, -J])
            slack_b = np.concatenate([limit + V, limit - V])
            kept = self._can_bind(slack_A, slack_b)
            A.append(slack_A[kept])
            b.append(slack_b[kept])
        return DenseProgram(H, c, np.concatenate(A), np.concatenate(b))

    def _can_bind(self, A: np.ndarray, b: np.ndarray) -> np.ndarray:
        """Which rows A u <= b the bounds on u do not imply, (m,) bool."""
        center = 0.5 * (self.upper + self.lower)
        radius = 0.5 * (self.upper - self.lower)
        return A @ center + np.abs(A) @ radius > b


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
