"""Inverse kinematics of arms from many seeds, in one compiled loop.

Damped least squares (Wampler 1986, Nakamura and Hanafusa 1986): each step is
J' (J J' + lambda^2 I)^-1 e, clamped to the joints' bounds.
"""

import math

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.vectors import dot
from remosplat_drake.robot.kinematics import REVOLUTE, compose, joint_pose
from remosplat_drake.robot.target_arrays import (
    asked_rotation,
    has_free,
    target_of,
)

_LENGTH = 0.3
"""Length by which angles of the pose error are weighed [m]."""

_LONGEST_STEP = 0.5
"""Largest change of a joint in one step [rad, m]."""


@kernel
def reach_from(chains, aim, first, lower, upper, seeds, steps, tolerance):
    """Solves for configurations that bring each E to its T, from k seeds.

    Args:
        chains: The joints that move each end effector, as `SerialChain`s in a
            tuple.
        aim: The `AimArrays`.
        first: Entry of q at which the arms begin.
        lower: Lower bounds of q, shape (n_q,) [rad, m].
        upper: Upper bounds of q, shape (n_q,) [rad, m].
        seeds: Configurations to start from, shape (k, n_q); what carries the
            arms stays where it is.
        steps: Largest number of steps from a seed; with 0 the seeds' own
            errors are measured.
        tolerance: Error that is small enough, angles weighed by 0.3 m [m].

    Returns:
        Where each seed has led to, shape (k, n_q), and the errors there,
        shape (k,) [m].
    """
    q = seeds.copy()
    error = np.empty(len(q))
    n, rows = q.shape[1] - first, 6 * len(aim.effector)
    X_WF, X_WE = np.zeros((q.shape[1], 4, 4)), np.zeros((4, 4))
    J, e = np.zeros((rows, n)), np.empty(rows)
    step, L = np.empty(n), np.zeros((rows, rows))
    for k in range(len(q)):
        damping = 0.05
        before = np.inf
        for i in range(steps + 1):
            for c in range(len(aim.effector)):
                chain, target = chains[aim.effector[c]], target_of(aim, c)
                at = slice(6 * c, 6 * c + 6)
                _place(chain, q[k], X_WF, X_WE)
                _error(X_WE, target, e[at])
                _jacobian(chain, first, X_WF, X_WE, target, J[at])
            size = 0.0
            for r in range(rows):
                size += e[r] * e[r]
            size = math.sqrt(size)
            error[k] = size
            if size < tolerance or i == steps:
                break
            # A step that does not help was too bold.
            damping = 0.5 * damping if size < before else 4.0 * damping
            damping = min(max(damping, 1e-4), 0.5)
            before = size
            _damped_step(J, e, damping, L, step)
            longest = _LONGEST_STEP
            for j in range(n):
                longest = max(longest, abs(step[j]))
            scale = _LONGEST_STEP / longest
            for j in range(n):
                entry = first + j
                value = q[k, entry] + scale * step[j]
                q[k, entry] = min(max(value, lower[entry]), upper[entry])
    return q, error


@helper
def _place(chain, q, X_WF, X_WE):
    """Fills in the poses of the joints' inboard frames and of E."""
    X_FM, X_WM = np.zeros((4, 4)), np.eye(4)
    for j in range(len(chain.kind)):
        compose(X_WM, chain.X_MF[j], X_WF[j])
        joint_pose(chain.kind[j], chain.axis_F[j], q[chain.position[j]], X_FM)
        compose(X_WF[j], X_FM, X_WM)
    compose(X_WM, chain.X_ME, X_WE)


@helper
def _error(X_WE, target, e):
    """Fills in the weighed error in what is asked."""
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
    """Turns a twist from W's axes into T's, with zeros where that is free."""
    for first in (0, 3):
        x, y, z = twist[first], twist[first + 1], twist[first + 2]
        for axis in range(3):
            total = 0.0
            if target.weights[first + axis] != 0.0:
                total = dot((x, y, z), target.X_WT[:3, axis])
            twist[first + axis] = total


@helper
def _jacobian(chain, first, X_WF, X_WE, target, J):
    """Fills in the Jacobian of what is asked, angles weighed as in the error.

    Its columns are the arms' joints; those that do not move E stay as they are.
    """
    a, is_less = np.empty(3), has_free(target.weights)
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
        if is_less:
            _leave_free(target, J[:, j])


@helper
def _damped_step(J, e, damping, L, step):
    """Fills in J' (J J' + damping^2 I)^-1 e, and the Cholesky factor L."""
    rows = len(e)
    for r in range(rows):
        for c in range(r + 1):
            total = damping * damping if r == c else 0.0
            for j in range(J.shape[1]):
                total += J[r, j] * J[c, j]
            for i in range(c):
                total -= L[r, i] * L[c, i]
            L[r, c] = math.sqrt(total) if r == c else total / L[c, c]
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
