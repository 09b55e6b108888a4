"""Which rows of a program hold its optimum back, and what pushes there."""

import numpy as np

from remosplat_drake.controller.compiled_program import CompiledProgram
from remosplat_drake.controller.program_data import ProgramData
from remosplat_drake.signals.binding import (
    BOUND,
    NONE_BINDS,
    Binding,
    BoundRow,
)

TIGHT = 1e-4
"""Rows this close to equality count as tight [m/s, rad/s]."""


def find_binding(program: ProgramData, u: np.ndarray) -> Binding:
    """Finds the rows that hold with equality at the optimum of a program.

    Bounds on the command are among them where any other row is: they bear a
    part of the push.

    Args:
        program: The program.
        u: Its optimum, shape (n_u,).
    """
    if isinstance(program, CompiledProgram):
        return program.binding(u, TIGHT)
    tight = program.tight_rows(u, TIGHT)
    if not tight:
        return NONE_BINDS
    found: list[BoundRow] = []
    coefficients: list[np.ndarray] = []
    for name, i in tight:
        rows = program.rows[name]
        found.append(BoundRow(name, i, rows.about(i)))
        coefficients.append(rows.A[i])
    eye = np.eye(program.n_u)
    for sign, tight in (
        (1.0, u >= program.upper - TIGHT),
        (-1.0, u <= program.lower + TIGHT),
    ):
        for i in np.flatnonzero(tight).tolist():
            found.append(BoundRow(BOUND, i, ()))
            coefficients.append(sign * eye[i])
    return Binding(tuple(found), np.array(coefficients), _descent(program, u))


def _descent(program: ProgramData, u: np.ndarray) -> np.ndarray:
    """Direction in which the cost falls at u, shape (n_u,)."""
    push = -program.weights * u - program.slope
    for tracking in program.trackings.values():
        missed = tracking.V - tracking.J @ u
        push = push + tracking.price * missed @ tracking.J
    return push
