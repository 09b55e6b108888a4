"""Finds the active rows at the optimum, and the gradient of the cost."""

import numpy as np

from remosplat_drake.base.kernels import helper

TIGHT = 1e-4
"""Difference b - A u up to which a row counts as active [m/s, rad/s]."""

BOUND_PART = -1
"""Number that replaces the ingredient's number for bounds of the command."""


@helper
def binding_arrays(program, u):
    """Finds the rows that hold with equality at the optimum of a program.

    Active bounds of the command are included if any other row is active, since
    they balance a part of the cost's gradient.

    Args:
        program: The `ProgramArrays`, pruned.
        u: Optimum of the program, shape (n_u,).

    Returns:
        Three arrays, which are empty if only bounds are active. The first has,
        for each active row, the number of its ingredient or BOUND_PART, its
        index among the rows of this ingredient, and its subject, shape (k, 3).
        The second has the coefficients of the rows, shape (k, n_u). The third
        is the negative gradient of the cost, shape (n_u,).
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
    """Returns the negative gradient of the cost at u, shape (n_u,)."""
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
