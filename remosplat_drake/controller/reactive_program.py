"""The quadratic program of one tick, built by its ingredients.

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

from remosplat_drake.controller.drake_program import DrakeProgram, fill
from remosplat_drake.controller.guidance.guidance import DIRECT, Guidance
from remosplat_drake.controller.program_data import ProgramData, Rows
from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.robot.robot_model import RobotModel, RobotState
from remosplat_drake.signals.distance_field import Clearances


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


class Ingredient(Protocol):
    """A cost or constraint of the program."""

    def AddToProgram(self, program: "ReactiveProgram", tick: Tick) -> None:
        """Adds what the ingredient stands for, described by its name."""
        ...


class ReactiveProgram(ProgramData):
    """What the ingredients of one tick add to.

    `prog` is the same as Drake's `MathematicalProgram`, `dense` as matrices
    in u alone. An ingredient may add to `prog` itself what the methods here
    do not express; then there is no `dense`.

    Attributes:
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
        super().__init__(velocity_limit)
        self.use_acceleration = use_acceleration
        self.has_acceleration_bounds = False
        self.relax = relax
        self.yielded: list[str] = []
        self._drake: DrakeProgram | None = None
        self._is_finished = False

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
            kept = self.can_bind(rows.A, rows.b)
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
