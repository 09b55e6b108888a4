"""The program of a tick as Drake's `MathematicalProgram`."""

import numpy as np
from pydrake.solvers import (
    EvaluatorBase,
    MathematicalProgram,
    QuadraticCost,
)

from remosplat_drake.controller.program_data import ProgramData, Tracking
from remosplat_drake.controller.slack_form import SlackForm
from remosplat_drake.controller.term import Term

_ROUNDING = 1e-12
"""Errors of the eigenvalues of a cost's matrix, relative to the largest."""


class DrakeProgram:
    """A `MathematicalProgram` in u and delta, its bindings described by name.

    Args:
        n_u: Number of entries of the command u.
        extended: Whether ingredients may still add terms to `prog`.

    Attributes:
        prog: The `MathematicalProgram` itself.
        u: Decision variables of the command, shape (n_u,).
        delta: Decision variables of the slack of the end-effector twists, one
            for each direction that is tracked, shape (r,); none until a
            finished program is filled in.
        extended: Whether an ingredient may have added terms to `prog` itself,
            of which the plain data know nothing.
    """

    def __init__(self, n_u: int, *, extended: bool):
        self.prog = MathematicalProgram()
        self.u = self.prog.NewContinuousVariables(n_u, "u")
        self.delta = self.u[:0]
        self.extended = extended


class KeptProgram:
    """A `MathematicalProgram` that is kept from tick to tick.

    Making variables and bindings takes Drake longer than filling them in.

    Args:
        n_u: Number of entries of the command u.
        r: Number of entries of the slack delta.

    Attributes:
        prog: The `MathematicalProgram` itself.
        u: Decision variables of the command, shape (n_u,).
    """

    def __init__(self, n_u: int, r: int):
        self.prog = MathematicalProgram()
        self.u = self.prog.NewContinuousVariables(n_u, "u")
        self._size = n_u, r
        delta = self.prog.NewContinuousVariables(r, "delta")
        x = np.concatenate([self.u, delta])
        one, none = np.ones(n_u + r), np.zeros(n_u + r)
        self._bounds = self.prog.AddBoundingBoxConstraint(-one, one, x)
        self._rows = self.prog.AddLinearConstraint(
            np.zeros((1, n_u)), np.full(1, -np.inf), np.zeros(1), self.u
        )
        self._twists = self.prog.AddLinearEqualityConstraint(
            np.hstack([np.zeros((r, n_u)), np.eye(r)]), none[n_u:], x
        )
        self._cost = self.prog.AddQuadraticCost(
            np.diag(one), none, x, is_convex=True
        )

    def has_size(self, n_u: int, r: int) -> bool:
        """Tells whether it has so many entries of u and delta."""
        return self._size == (n_u, r)

    def fill(self, form: SlackForm) -> None:
        """Fills a tick's program in.

        Args:
            form: The program, of the same size.
        """
        self._bounds.evaluator().set_bounds(
            np.concatenate([form.lower, form.slack_lower]),
            np.concatenate([form.upper, form.slack_upper]),
        )
        self._rows.evaluator().UpdateCoefficients(
            form.A, np.full(len(form.b), -np.inf), form.b
        )
        self._twists.evaluator().UpdateCoefficients(form.J, form.V)
        self._cost.evaluator().UpdateCoefficients(form.Q, form.c, 0.0, True)


def check_terms(prog: MathematicalProgram) -> None:
    """Checks the terms of a program that ingredients have written themselves.

    Args:
        prog: The program.

    Raises:
        TermError: A term is not finite, or is a concave cost.
    """
    for binding in [*prog.GetAllCosts(), *prog.GetAllConstraints()]:
        _check_evaluator(binding.evaluator())


def _check_evaluator(evaluator: EvaluatorBase) -> None:
    term = Term(type(evaluator).__name__, evaluator.get_description())
    # One coefficient that is not finite makes the value so, wherever it is.
    value = evaluator.Eval(np.ones(evaluator.num_vars()))
    if not np.isfinite(value).all():
        raise term.error("it is not finite")
    if isinstance(evaluator, QuadraticCost):
        curvatures = np.linalg.eigvalsh(evaluator.Q())
        if curvatures[0] < -_ROUNDING * np.abs(curvatures).max():
            raise term.error("the cost is concave")


def fill(drake: DrakeProgram, program: ProgramData) -> None:
    """Adds the terms of a program to Drake's program.

    Rows that the bounds on u imply are left out.

    Args:
        drake: The program that takes costs, bounds and rows.
        program: The terms as plain data.
    """
    prog, u = drake.prog, drake.u
    prog.AddBoundingBoxConstraint(
        program.lower, program.upper, u
    ).evaluator().set_description("command bounds")
    for name, rows in program.rows.items():
        if rows.kept.any():
            b = rows.b[rows.kept]
            prog.AddLinearConstraint(
                rows.A[rows.kept], np.full(len(b), -np.inf), b, u
            ).evaluator().set_description(name)
    for name, c in program.linear.items():
        prog.AddLinearCost(c, 0.0, u).evaluator().set_description(name)
    for name, weights in program.quadratic.items():
        prog.AddQuadraticCost(
            np.diag(weights), np.zeros(len(weights)), u, is_convex=True
        ).evaluator().set_description(name)
    for tracking in program.trackings.values():
        _add_tracking(drake, tracking)


def _add_tracking(drake: DrakeProgram, tracking: Tracking) -> None:
    prog, r = drake.prog, len(tracking.V)
    of = f" of {tracking.name}" if len(drake.delta) else ""
    delta = prog.NewContinuousVariables(r, "delta")
    drake.delta = np.concatenate([drake.delta, delta])
    prog.AddLinearEqualityConstraint(
        np.hstack([tracking.J, np.eye(r)]),
        tracking.V,
        np.concatenate([drake.u, delta]),
    ).evaluator().set_description(tracking.name)
    prog.AddBoundingBoxConstraint(
        -tracking.limit, tracking.limit, delta
    ).evaluator().set_description(f"slack limit{of}")
    prog.AddQuadraticCost(
        tracking.price * np.eye(r), np.zeros(r), delta, is_convex=True
    ).evaluator().set_description(f"slack{of}")
