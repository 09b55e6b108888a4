"""Converts the quadratic program of a tick for solvers, and solves it."""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import reals, several
from remosplat_drake.controller.program.active_set import (
    INFEASIBLE,
    solve_dense,
)

HOPELESS = 1e-3
"""Violation of a row above which it is infeasible [m/s, rad/s]. If every u
within the bounds violates a row by more than this value, no solver is called.
The value exceeds the tolerances of solvers."""


@helper
def solve_program(program):
    """Solves the program of a tick; see `active_set.solve_dense`.

    Args:
        program: The `ProgramArrays`, pruned.

    Returns:
        The optimum u, shape (n_u,), and the solver's status.
    """
    if program.count[4]:
        return np.zeros(len(program.lower)), INFEASIBLE
    H, c, A, b = dense(*slack_form(program))
    u, _, ended = solve_dense(H, c, A, b)
    return u, ended


@helper
def prune(program) -> None:
    """Marks the rows that may be active, which the bounds of u do not imply.

    The function also stores whether every u within the bounds violates some
    row. This happens, for example, if a mover approaches faster than the robot
    can retreat.

    Args:
        program: The `ProgramArrays`.
    """
    program.count[4] = 0
    for i in range(program.count[0]):
        least, most = span(program, program.A[i])
        # The comparison is written so that a row with NaN is kept, which makes
        # the program infeasible.
        program.kept[i] = not most <= program.b[i]
        if not least <= program.b[i] + HOPELESS:
            program.count[4] = 1


@helper
def span(program, a):
    """Computes the least and the greatest value of a'u within the bounds of u.

    Args:
        program: The `ProgramArrays`.
        a: Coefficients, shape (n_u,).
    """
    least, most = 0.0, 0.0
    for j in range(len(a)):
        lower, upper = program.lower[j], program.upper[j]
        center, radius = a[j] * (upper + lower), abs(a[j]) * (upper - lower)
        least += 0.5 * (center - radius)
        most += 0.5 * (center + radius)
    return least, most


@helper
def _add_costs(program, H, c) -> None:
    """Adds the ingredients' costs to the entries of H and c for u."""
    for k in range(len(program.linear)):
        for j in range(len(program.lower)):
            c[j] += program.linear[k, j]
            H[j, j] += program.quadratic[k, j]


@helper
def _copy_kept(program, A, b, row):
    """Copies the kept rows to `A` from a row on; returns the next row."""
    for i in range(program.count[0]):
        if program.kept[i]:
            for j in range(len(program.lower)):
                A[row, j] = program.A[i, j]
            b[row] = program.b[i]
            row += 1
    return row


@kernel(returns=several(reals(2), reals(1), reals(2), reals(1)))
def dense(lower, upper, slack_lower, slack_upper, A, b, J, V, Q, c):
    """Computes the program in u alone, in which V - J u replaces the slack.

    Args:
        lower: See `SlackForm`, which has all arguments as attributes.
        upper: See `SlackForm`.
        slack_lower: See `SlackForm`.
        slack_upper: See `SlackForm`.
        A: See `SlackForm`.
        b: See `SlackForm`.
        J: See `SlackForm`.
        V: See `SlackForm`.
        Q: See `SlackForm`.
        c: See `SlackForm`.

    Returns:
        The four arrays of a `DenseProgram`.
    """
    n_u, m, r = len(lower), len(b), len(V)
    H, slope = Q[:n_u, :n_u].copy(), c[:n_u].copy()
    rows, most = (
        np.zeros((2 * n_u + m + 2 * r, n_u)),
        np.empty(2 * (n_u + r) + m),
    )
    for j in range(n_u):
        rows[j, j], most[j] = 1.0, upper[j]
        rows[n_u + j, j], most[n_u + j] = -1.0, -lower[j]
    for i in range(m):
        most[2 * n_u + i] = b[i]
        for j in range(n_u):
            rows[2 * n_u + i, j] = A[i, j]
    for k in range(r):
        price = Q[n_u + k, n_u + k]
        for i in range(n_u):
            slope[i] -= price * V[k] * J[k, i]
            for j in range(n_u):
                H[i, j] += price * J[k, i] * J[k, j]
    row = 2 * n_u + m
    for sign in (1.0, -1.0):
        for k in range(r):
            limit = -slack_lower[k] if sign > 0.0 else slack_upper[k]
            if limit == np.inf:
                continue
            for j in range(n_u):
                rows[row, j] = sign * J[k, j]
            most[row] = limit + sign * V[k]
            row += 1
    return H, slope, rows[:row], most[:row]


@kernel(returns=several(*map(reals, (1, 1, 1, 1, 2, 1, 2, 1, 2, 1))))
def slack_form(program):
    """Computes the program in u and the slack.

    Args:
        program: The `ProgramArrays`, pruned.

    Returns:
        The ten arrays of a `SlackForm`.
    """
    n_u, r = len(program.lower), program.count[3]
    Q, c = np.zeros((n_u + r, n_u + r)), np.zeros(n_u + r)
    _add_costs(program, Q, c)
    A, b = np.empty((program.count[0], n_u)), np.empty(program.count[0])
    m = _copy_kept(program, A, b, 0)
    J = np.zeros((r, n_u + r))
    slack_lower, slack_upper = np.full(r, -np.inf), np.full(r, np.inf)
    for k in range(r):
        for j in range(n_u):
            J[k, j] = program.J[k, j]
        J[k, n_u + k], Q[n_u + k, n_u + k] = 1.0, program.price[k]
        least, most = span(program, program.J[k])
        limit, V = program.limit[k], program.V[k]
        if most > limit + V:
            slack_lower[k] = -limit
        if -least > limit - V:
            slack_upper[k] = limit
    return (
        program.lower.copy(),
        program.upper.copy(),
        slack_lower,
        slack_upper,
        A[:m],
        b[:m],
        J,
        program.V[:r].copy(),
        Q,
        c,
    )
