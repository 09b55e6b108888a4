"""Solves small, strictly convex quadratic programs by an active-set method.

Rollouts solve thousands of similar programs with about nine unknowns. The dual
active-set method of Goldfarb and Idnani (1983) starts at the unconstrained
optimum, and adds one violated row after the other to the active set. If few
rows are active, this takes a few microseconds. Tests compare the results with
those of Drake's `ClarabelSolver`.
"""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import WHOLE, reals, several

OPTIMAL, INFEASIBLE, UNDECIDED = 0, 1, 2
"""Statuses of `solve_dense`. In order, they mean that u is the optimum; that no
u satisfies all rows; and that rounding errors prevent a decision, so that the
caller must use another solver."""

_TOLERANCE = 1e-10
"""Violation of a row up to which it counts as zero, if the row is scaled to
unit length."""

_DEPENDENT = 1e-12
"""Squared length of a row's component orthogonal to the active rows. If it is
smaller than this value, the row counts as linearly dependent on them."""

_STATIONARY = 1e-6
"""Largest residual of H u + c + A' multipliers = 0, relative to the larger of H
u and c. If a nearly dependent row has a very large multiplier, the terms that
are neglected because of `_DEPENDENT` are large, and the residual exceeds this
limit."""

_MAX_STEPS = 500


class DenseProgram(NamedTuple):
    """The quadratic program: minimise 1/2 u'Hu + c'u subject to A u <= b.

    Attributes:
        H: Symmetric positive definite matrix of the cost, shape (n, n).
        c: Vector of the linear cost, shape (n,).
        A: Coefficients of the inequality rows, shape (m, n).
        b: Right-hand sides of the rows, shape (m,).
    """

    H: np.ndarray
    c: np.ndarray
    A: np.ndarray
    b: np.ndarray


@kernel(returns=several(reals(1), reals(1), WHOLE))
def solve_dense(H, c, A, b):
    """Minimises 1/2 u'Hu + c'u subject to A u <= b.

    The method is the dual active-set method of Goldfarb and Idnani (1983).

    Args:
        H: Symmetric positive definite matrix of the cost, shape (n, n).
        c: Vector of the linear cost, shape (n,).
        A: Coefficients of the inequality rows, shape (m, n).
        b: Right-hand sides of the rows, shape (m,).

    Returns:
        The minimiser u, shape (n,), the Lagrange multipliers of the rows, shape
        (m,), and the status: OPTIMAL, INFEASIBLE or UNDECIDED. u and the
        multipliers are valid only if the status is OPTIMAL.
    """
    n, m = len(c), len(b)
    multipliers = np.zeros(m)
    L = np.zeros((n, n))
    if not _cholesky(H, L):
        return np.zeros(n), multipliers, UNDECIDED
    length = np.zeros(m)
    for i in range(m):
        for j in range(n):
            length[i] += A[i, j] * A[i, j]
        length[i] = np.sqrt(length[i])
    u = _backward(L, _forward(L, -c))
    active = np.zeros(n, np.int64)
    weight = np.zeros(n)
    n_active = 0
    Q, R = np.zeros((n, n)), np.zeros((n, n))
    for _ in range(_MAX_STEPS):
        entering, excess = _most_violated(A, b, length, u)
        if entering < 0:
            for k in range(n_active):
                multipliers[active[k]] = weight[k]
            is_optimum = _is_stationary(H, c, A, u, active, weight, n_active)
            return u, multipliers, OPTIMAL if is_optimum else UNDECIDED
        n_active = _take_in(
            entering, excess, L, A, u, active, weight, n_active, Q, R
        )
        if n_active < 0:
            return u, multipliers, INFEASIBLE
    return u, multipliers, UNDECIDED


@helper
def _is_stationary(H, c, A, u, active, weight, n_active):
    """Whether the gradient of the Lagrangian vanishes at u."""
    residual, scale = 0.0, 0.0
    for j in range(len(u)):
        steep, pull = 0.0, 0.0
        for i in range(len(u)):
            steep += H[j, i] * u[i]
        for k in range(n_active):
            pull += weight[k] * A[active[k], j]
        residual = max(residual, abs(steep + c[j] + pull))
        scale = max(scale, abs(steep), abs(c[j]))
    return residual <= _STATIONARY * scale


@helper
def _take_in(entering, excess, L, A, u, active, weight, n_active, Q, R):
    """Adds a violated row to the active set, and moves u until it is active.

    If the multiplier of an active row reaches zero during this motion, the row
    is removed from the active set.

    Returns:
        The number of active rows; -1 if the row is incompatible with the active
        rows.
    """
    price = 0.0
    y = _forward(L, A[entering])
    scale = _dot(y, y)
    if scale == 0.0:
        return -1
    while True:
        _factor(L, A, active, n_active, Q, R)
        rest, r = _project(Q, R, y, n_active)
        curvature = _dot(rest, rest)
        leaving, step = _blocking(weight, r, n_active)
        moves = n_active < len(u) and curvature > _DEPENDENT * scale
        if not moves and leaving < 0:
            return -1
        arrives = moves and excess / curvature <= step
        if arrives:
            step = excess / curvature
        if moves:
            z = _backward(L, rest)
            for j in range(len(u)):
                u[j] -= step * z[j]
            excess -= step * curvature
        for k in range(n_active):
            weight[k] -= step * r[k]
        price += step
        if arrives:
            active[n_active], weight[n_active] = entering, price
            return n_active + 1
        n_active = _drop(active, weight, n_active, leaving)


@helper
def _dot(a, b):
    total = 0.0
    for j in range(len(a)):
        total += a[j] * b[j]
    return total


@helper
def _most_violated(A, b, length, u):
    """Returns the most violated row, or -1, and its excess A u - b."""
    entering, excess, most = -1, 0.0, _TOLERANCE
    for i in range(len(b)):
        value = -b[i]
        for j in range(len(u)):
            value += A[i, j] * u[j]
        scaled = value / length[i] if length[i] > 0.0 else value
        if scaled > most * max(1.0, abs(b[i])):
            entering, excess, most = i, value, scaled
    return entering, excess


@helper
def _blocking(weight, r, n_active):
    """Returns the row whose multiplier reaches zero first, and the step."""
    leaving, step = -1, np.inf
    for k in range(n_active):
        if r[k] > 0.0 and weight[k] / r[k] < step:
            leaving, step = k, weight[k] / r[k]
    return leaving, step


@helper
def _drop(active, weight, n_active, leaving):
    """Removes a row from the active set; returns the new number of rows."""
    for k in range(leaving, n_active - 1):
        active[k], weight[k] = active[k + 1], weight[k + 1]
    return n_active - 1


@helper
def _factor(L, A, active, n_active, Q, R):
    """Factors Q R = L^-1 N by Gram-Schmidt; columns of N are active rows."""
    for k in range(n_active):
        column = _forward(L, A[active[k]])
        for i in range(k):
            # Orthogonalisation is repeated, so that Q is orthogonal up to
            # rounding errors.
            R[i, k] = 0.0
        for _ in range(2):
            for i in range(k):
                dot = 0.0
                for j in range(len(column)):
                    dot += Q[j, i] * column[j]
                R[i, k] += dot
                for j in range(len(column)):
                    column[j] -= dot * Q[j, i]
        norm = np.sqrt(_dot(column, column))
        R[k, k] = norm
        for j in range(len(column)):
            Q[j, k] = column[j] / norm


@helper
def _project(Q, R, y, n_active):
    """Computes the part of y orthogonal to the span of Q, and r = R^-1 Q'y."""
    rest, dots = y.copy(), np.zeros(n_active)
    for _ in range(2):
        for k in range(n_active):
            dot = 0.0
            for j in range(len(y)):
                dot += Q[j, k] * rest[j]
            dots[k] += dot
            for j in range(len(y)):
                rest[j] -= dot * Q[j, k]
    r = np.zeros(n_active)
    for k in range(n_active - 1, -1, -1):
        total = dots[k]
        for i in range(k + 1, n_active):
            total -= R[k, i] * r[i]
        r[k] = total / R[k, k]
    return rest, r


@helper
def _cholesky(H, L):
    """Fills the lower triangle of L with L L' = H; False if there is none."""
    for row in range(len(H)):
        for column in range(row + 1):
            total = H[row, column]
            for k in range(column):
                total -= L[row, k] * L[column, k]
            if row > column:
                L[row, column] = total / L[column, column]
            elif total > 0.0:
                L[row, row] = np.sqrt(total)
            else:
                return False
    return True


@helper
def _forward(L, x):
    """Computes L^-1 x by forward substitution."""
    y = x.copy()
    for row in range(len(y)):
        for k in range(row):
            y[row] -= L[row, k] * y[k]
        y[row] /= L[row, row]
    return y


@helper
def _backward(L, x):
    """Computes L'^-1 x by backward substitution."""
    y = x.copy()
    for row in range(len(y) - 1, -1, -1):
        for k in range(row + 1, len(y)):
            y[row] -= L[k, row] * y[k]
        y[row] /= L[row, row]
    return y
