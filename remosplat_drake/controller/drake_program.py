"""The program of a tick as Drake's `MathematicalProgram`."""

import numpy as np
from pydrake.solvers import MathematicalProgram

from remosplat_drake.controller.program_data import ProgramData, Tracking


class DrakeProgram:
    """A `MathematicalProgram` in u and delta, its bindings described by name.

    Attributes:
        prog: Drake's program.
        x: All decision variables, u then delta.
        u: Decision variables of the command.
        delta: Slack of the end-effector twist (angular, translational).
        extended: Whether an ingredient has added to it by itself.
    """

    def __init__(self, n_u: int, *, extended: bool):
        self.prog = MathematicalProgram()
        self.x = self.prog.NewContinuousVariables(n_u + 6, "x")
        self.u, self.delta = self.x[:n_u], self.x[n_u:]
        self.extended = extended


def fill(drake: DrakeProgram, program: ProgramData) -> None:
    """Adds costs, bounds and rows, less those that the bounds imply."""
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
