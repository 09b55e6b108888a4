"""Inverse kinematics of arms from a seed, and their manipulability.

Damped least squares (Wampler 1986, Nakamura and Hanafusa 1986): each step is
J' (J J' + lambda^2 I)^-1 e, clamped to the joints' bounds.
"""

import math
from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import REAL
from remosplat_drake.base.vectors import dot
from remosplat_drake.robot.kinematics import REVOLUTE, compose
from remosplat_drake.robot.serial_chain import SerialChain
from remosplat_drake.robot.target_arrays import (
    AimArrays,
    asked_rotation,
    has_free,
    target_of,
)

_LENGTH = 0.3
"""Length by which angles of the pose error are multiplied [m]."""

_LONGEST_STEP = 0.5
"""Largest change of a joint in one step [rad, m]."""

_DOUBT = 8
"""Step after which the iteration ends if the error is still large. Of the seeds
that reach the aim, nine in ten have a smaller error by then."""

_HOPELESS = 0.1
"""Error that counts as large at step `_DOUBT` [m]."""

_NO_DAMPING = 1e-6
"""Small damping that prevents divisions by zero."""


class Arms(NamedTuple):
    """The arms of a robot, and their targets.

    Attributes:
        chains: The joints that move each end effector, a tuple of
            `SerialChain`s.
        aim: The `AimArrays`.
        first: Index in q of the arms' first joint.
        lower: Lower bounds of q, shape (n_q,) [rad, m].
        upper: Upper bounds of q, shape (n_q,) [rad, m].
    """

    chains: tuple[SerialChain, ...]
    aim: AimArrays
    first: int
    lower: np.ndarray
    upper: np.ndarray


@kernel(returns=REAL)
def reach_from(arms, q, steps, tolerance):
    """Solves for a configuration in which each end effector E is at its target.

    Args:
        arms: The `Arms`.
        q: Input: the seed, from which the iteration starts; output: the final
            configuration, shape (n_q,) [rad, m]. Entries before those of the
            arms do not change.
        steps: Largest number of steps; with 0, only the seed's error is
            computed.
        tolerance: Error at which the iteration ends, with angles times 0.3 m
            [m].

    Returns:
        The final error, with angles times 0.3 m [m].
    """
    aim, chains, first = arms.aim, arms.chains, arms.first
    lower, upper = arms.lower, arms.upper
    n, rows = len(q) - first, 6 * len(aim.effector)
    X_WF, X_WE = np.zeros((len(q), 4, 4)), np.zeros((4, 4))
    J, e = np.zeros((rows, n)), np.empty(rows)
    step, L = np.empty(n), np.zeros((rows, rows))
    damping, before, error = 0.05, np.inf, np.inf
    for i in range(steps + 1):
        for c in range(len(aim.effector)):
            chain, target = chains[aim.effector[c]], target_of(aim, c)
            at = slice(6 * c, 6 * c + 6)
            _place(chain, q, X_WF, X_WE)
            _error(X_WE, target, e[at])
            if i < steps:
                _jacobian(chain, first, X_WF, X_WE, J[at])
                _leave_columns(target, J[at])
        error = 0.0
        for r in range(rows):
            error += e[r] * e[r]
        error = math.sqrt(error)
        if error < tolerance or i == steps:
            break
        if i == _DOUBT and error > _HOPELESS:
            break
        # A step that does not reduce the error was too large.
        damping = 0.5 * damping if error < before else 4.0 * damping
        damping = min(max(damping, 1e-4), 0.5)
        before = error
        _damped_step(J, e, damping, L, step)
        longest = _LONGEST_STEP
        for j in range(n):
            longest = max(longest, abs(step[j]))
        scale = _LONGEST_STEP / longest
        for j in range(n):
            value = q[first + j] + scale * step[j]
            q[first + j] = min(max(value, lower[first + j]), upper[first + j])
    return error


@kernel(returns=REAL)
def least_manipulability(arms, q):
    """Returns the least of the arms' sqrt(det(J J')) (Yoshikawa 1985).

    The manipulability of an arm with fewer than six joints counts as 1.

    Args:
        arms: The `Arms`.
        q: The configuration, shape (n_q,) [rad, m].
    """
    aim, n = arms.aim, len(q) - arms.first
    if n < 6:
        return 1.0
    X_WF, X_WE = np.zeros((len(q), 4, 4)), np.zeros((4, 4))
    J, L = np.zeros((6, n)), np.zeros((6, 6))
    least = np.inf
    for c in range(len(aim.effector)):
        chain = arms.chains[aim.effector[c]]
        _place(chain, q, X_WF, X_WE)
        for r in range(6):
            for j in range(n):
                J[r, j] = 0.0
        _jacobian(chain, arms.first, X_WF, X_WE, J)
        _factor(J, _NO_DAMPING, L)
        found = 1.0
        for r in range(6):
            found *= L[r, r]
        least = min(least, found / _LENGTH**3)
    return least


@helper
def _place(chain, q, X_WF, X_WE):
    """Fills in the poses of the joints' inboard frames and of E."""
    X_WM = np.eye(4)
    for j in range(len(chain.kind)):
        compose(X_WM, chain.X_MF[j], X_WF[j])
        value = q[chain.position[j]]
        _move(chain.kind[j], chain.axis_F[j], value, X_WF[j], X_WM)
    compose(X_WM, chain.X_ME, X_WE)


@helper
def _move(kind, axis_F, value, X_WF, X_WM):
    """Computes the pose of a joint's moving body from that of its frame F."""
    x, y, z = axis_F[0], axis_F[1], axis_F[2]
    if kind != REVOLUTE:
        for r in range(3):
            along = X_WF[r, 0] * x + X_WF[r, 1] * y + X_WF[r, 2] * z
            X_WM[r, 3] = X_WF[r, 3] + value * along
            for c in range(3):
                X_WM[r, c] = X_WF[r, c]
        return
    s, c = math.sin(value), math.cos(value)
    v = 1.0 - c
    for r in range(3):
        # Rodrigues' formula, multiplied by rows of R_WF.
        i, j, k = X_WF[r, 0], X_WF[r, 1], X_WF[r, 2]
        along = v * (i * x + j * y + k * z)
        X_WM[r, 0] = c * i + s * (j * z - k * y) + along * x
        X_WM[r, 1] = c * j + s * (k * x - i * z) + along * y
        X_WM[r, 2] = c * k + s * (i * y - j * x) + along * z
        X_WM[r, 3] = X_WF[r, 3]


@helper
def _error(X_WE, target, e):
    """Computes the weighted error in the constrained directions."""
    _pose_error(X_WE, target.X_WT, e)
    if has_free(target.weights):
        turn_W = asked_rotation(X_WE, target.X_WT, target.weights)
        for c in range(3):
            e[c] = _LENGTH * turn_W[c]
        _leave_free(target, e)


@helper
def _pose_error(X_WE, X_WT, e):
    """Fills in the weighed pose error from E to T, in W."""
    R = np.zeros((3, 3))
    for r in range(3):
        for c in range(3):
            for k in range(3):
                R[r, c] += X_WT[r, k] * X_WE[c, k]
    x = 0.5 * (R[2, 1] - R[1, 2])
    y = 0.5 * (R[0, 2] - R[2, 0])
    z = 0.5 * (R[1, 0] - R[0, 1])
    sine = math.sqrt(x * x + y * y + z * z)
    cosine = 0.5 * (R[0, 0] + R[1, 1] + R[2, 2] - 1.0)
    factor = 1.0
    if sine > 1e-9:
        factor = math.atan2(sine, cosine) / sine
    e[0] = _LENGTH * factor * x
    e[1] = _LENGTH * factor * y
    e[2] = _LENGTH * factor * z
    for r in range(3):
        e[3 + r] = X_WT[r, 3] - X_WE[r, 3]


@helper
def _leave_free(target, twist):
    """Rotates a twist from W into T, and sets free directions to zero."""
    for first in (0, 3):
        x, y, z = twist[first], twist[first + 1], twist[first + 2]
        for axis in range(3):
            total = 0.0
            if target.weights[first + axis] != 0.0:
                total = dot((x, y, z), target.X_WT[:3, axis])
            twist[first + axis] = total


@helper
def _leave_columns(target, J):
    """Removes the free directions from a Jacobian."""
    if has_free(target.weights):
        for j in range(J.shape[1]):
            _leave_free(target, J[:, j])


@helper
def _jacobian(chain, first, X_WF, X_WE, J):
    """Writes the Jacobian of a pose, with angles weighted as in the error.

    Its columns are the arms' joints; those that do not move E are left
    unchanged.
    """
    a = np.empty(3)
    for i in range(len(chain.kind)):
        j = chain.position[i] - first
        if j < 0:
            continue
        X, axis_F = X_WF[i], chain.axis_F[i]
        for r in range(3):
            a[r] = 0.0
            for c in range(3):
                a[r] += X[r, c] * axis_F[c]
        if chain.kind[i] == REVOLUTE:
            dx = X_WE[0, 3] - X[0, 3]
            dy = X_WE[1, 3] - X[1, 3]
            dz = X_WE[2, 3] - X[2, 3]
            for r in range(3):
                J[r, j] = _LENGTH * a[r]
            J[3, j] = a[1] * dz - a[2] * dy
            J[4, j] = a[2] * dx - a[0] * dz
            J[5, j] = a[0] * dy - a[1] * dx
        else:
            for r in range(3):
                J[r, j] = 0.0
                J[3 + r, j] = a[r]


@helper
def _factor(J, damping, L):
    """Fills in the Cholesky factor L of J J' + damping^2 I."""
    rows = len(J)
    for r in range(rows):
        for c in range(r + 1):
            total = damping * damping if r == c else 0.0
            for j in range(J.shape[1]):
                total += J[r, j] * J[c, j]
            for i in range(c):
                total -= L[r, i] * L[c, i]
            # Prevents a negative square from rounding.
            square = max(total, 0.25 * damping * damping)
            L[r, c] = math.sqrt(square) if r == c else total / L[c, c]


@helper
def _damped_step(J, e, damping, L, step):
    """Fills in J' (J J' + damping^2 I)^-1 e, and the Cholesky factor L."""
    rows = len(e)
    _factor(J, damping, L)
    x = np.empty(rows)
    for r in range(rows):
        x[r] = e[r]
        for i in range(r):
            x[r] -= L[r, i] * x[i]
        x[r] /= L[r, r]
    for r in range(rows - 1, -1, -1):
        for i in range(r + 1, rows):
            x[r] -= L[i, r] * x[i]
        x[r] /= L[r, r]
    for j in range(J.shape[1]):
        step[j] = 0.0
        for r in range(rows):
            step[j] += J[r, j] * x[r]
