"""Converts the quadratic program of a tick to a `MathematicalProgram`."""

import numpy as np
from pydrake.solvers import (
    EvaluatorBase,
    MathematicalProgram,
    QuadraticCost,
)

from remosplat_drake.controller.program.slack_form import SlackForm
from remosplat_drake.controller.program.term import Term

_ROUNDING = 1e-12
"""Bound of the relative rounding errors of a cost matrix's eigenvalues."""


class DrakeProgram:
    """A `MathematicalProgram` in u, to which ingredients add terms.

    Args:
        n_u: Number of entries of the command u.

    Attributes:
        prog: The `MathematicalProgram`.
        u: Decision variables of the command, shape (n_u,).
    """

    def __init__(self, n_u: int):
        self.prog = MathematicalProgram()
        self.u = self.prog.NewContinuousVariables(n_u, "u")

    def check(self) -> None:
        """Checks the terms that ingredients have added.

        Raises:
            TermError: A term is not finite, or is a concave cost.
        """
        for bound in [*self.prog.GetAllCosts(), *self.prog.GetAllConstraints()]:
            _check_evaluator(bound.evaluator())


class KeptProgram:
    """A `MathematicalProgram` of fixed size that is filled again at each tick.

    Making variables and bindings takes longer than setting values, so a solver
    uses the same `MathematicalProgram` at each tick.

    Args:
        n_u: Number of entries of the command u.
        r: Number of entries of the slack delta.
        extension: Additional terms of ingredients; None if there are none.

    Attributes:
        prog: The `MathematicalProgram`.
        u: Decision variables of the command, shape (n_u,).
    """

    def __init__(self, n_u: int, r: int, extension: DrakeProgram | None = None):
        if extension is None:
            extension = DrakeProgram(n_u)
        self.prog, self.u = extension.prog.Clone(), extension.u
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
        for bound, name in (
            (self._bounds, "bounds on u and delta"),
            (self._rows, "rows"),
            (self._twists, "tracked twists"),
            (self._cost, "costs"),
        ):
            bound.evaluator().set_description(name)

    def has_size(self, n_u: int, r: int) -> bool:
        """Returns whether u and delta have the given numbers of entries."""
        return self._size == (n_u, r)

    def fill(self, form: SlackForm) -> None:
        """Sets the values of a tick's program.

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


def _check_evaluator(evaluator: EvaluatorBase) -> None:
    term = Term(type(evaluator).__name__, evaluator.get_description())
    # If any coefficient is not finite, this value is not finite.
    value = evaluator.Eval(np.ones(evaluator.num_vars()))
    if not np.isfinite(value).all():
        raise term.error("it is not finite")
    if isinstance(evaluator, QuadraticCost):
        curvatures = np.linalg.eigvalsh(evaluator.Q())
        if curvatures[0] < -_ROUNDING * np.abs(curvatures).max():
            raise term.error("the cost is concave")
