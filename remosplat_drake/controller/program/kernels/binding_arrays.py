"""Finds the rows that hold an optimum back, and the forces there."""

import numpy as np

from remosplat_drake.base.kernels import helper

TIGHT = 1e-4
"""Rows this close to equality count as tight [m/s, rad/s]."""

BOUND_PART = -1
"""Number of the ingredient of rows that are bounds on the command."""


@helper
def binding_arrays(program, u):
    """Finds the rows that hold with equality at the optimum of a program.

    Bounds on the command are among them where any other row is: they bear a
    part of the push.

    Args:
        program: The `ProgramArrays`, pruned.
        u: Its optimum, shape (n_u,).

    Returns:
        For each row the number of its ingredient, or BOUND_PART, its number
        among the rows of that, and what it is about, shape (k, 3); the rows'
        coefficients, shape (k, n_u); and the direction in which the cost
        falls, shape (n_u,). No bounds are among them, and nothing is pushed,
        where no other row holds.
    """
    n_u = len(u)
    most = program.count[0] + 2 * n_u
    tight, A = np.empty((most, 3), np.int64), np.zeros((most, n_u))
    k = 0
    for part in range(len(program.rows)):
        first, last = program.rows[part]
        for i in range(first, last):
            if program.kept[i] and _is_tight(program, i, u):
                tight[k, 0], tight[k, 1] = part, i - first
                tight[k, 2] = program.about[i]
                for j in range(n_u):
                    A[k, j] = program.A[i, j]
                k += 1
    if k == 0:
        return tight[:0], A[:0], np.zeros(0)
    for sign in (1.0, -1.0):
        bound = program.upper if sign > 0.0 else program.lower
        for j in range(n_u):
            if sign * (u[j] - bound[j]) >= -TIGHT:
                tight[k, 0], tight[k, 1], tight[k, 2] = BOUND_PART, j, j
                A[k, j] = sign
                k += 1
    return tight[:k], A[:k], _descent(program, u)


@helper
def _is_tight(program, i, u):
    value = 0.0
    for j in range(len(u)):
        value += program.A[i, j] * u[j]
    return value >= program.b[i] - TIGHT


@helper
def _descent(program, u):
    """Direction in which the cost falls at u, shape (n_u,)."""
    push = np.zeros(len(u))
    for part in range(len(program.linear)):
        for j in range(len(u)):
            push[j] -= program.linear[part, j]
            push[j] -= program.quadratic[part, j] * u[j]
    for k in range(program.count[3]):
        missed = program.V[k]
        for j in range(len(u)):
            missed -= program.J[k, j] * u[j]
        for j in range(len(u)):
            push[j] += program.price[k] * missed * program.J[k, j]
    return push
