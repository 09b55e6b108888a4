"""The program of a tick as Drake's `MathematicalProgram`."""

import numpy as np
from pydrake.solvers import MathematicalProgram

from remosplat_drake.controller.program_data import ProgramData, Tracking


class DrakeProgram:
    """A `MathematicalProgram` in u and delta, its bindings described by name.

    Args:
        n_u: Number of entries of the command u.
        extended: Whether ingredients may still add terms to `prog`.

    Attributes:
        prog: The `MathematicalProgram` itself.
        x: All decision variables, u then delta, shape (n_u + 6,).
        u: Decision variables of the command, shape (n_u,).
        delta: Decision variables of the slack of the end-effector twist,
            angular above translational, shape (6,).
        extended: Whether an ingredient may have added terms to `prog` itself,
            of which the plain data know nothing.
    """

    def __init__(self, n_u: int, *, extended: bool):
        self.prog = MathematicalProgram()
        self.x = self.prog.NewContinuousVariables(n_u + 6, "x")
        self.u, self.delta = self.x[:n_u], self.x[n_u:]
        self.extended = extended


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
    if program.tracking is not None:
        _add_tracking(drake, program.tracking)


def _add_tracking(drake: DrakeProgram, tracking: Tracking) -> None:
    prog = drake.prog
    prog.AddLinearEqualityConstraint(
        np.hstack([tracking.J, np.eye(6)]), tracking.V, drake.x
    ).evaluator().set_description(tracking.name)
    prog.AddBoundingBoxConstraint(
        -tracking.limit, tracking.limit, drake.delta
    ).evaluator().set_description("slack limit")
    prog.AddQuadraticCost(
        tracking.price * np.eye(6), np.zeros(6), drake.delta, is_convex=True
    ).evaluator().set_description("slack")
