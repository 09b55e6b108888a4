"""Inverse kinematics of an arm from many seeds, in one compiled loop.

Damped least squares (Wampler 1986, Nakamura and Hanafusa 1986): each step is
J' (J J' + lambda^2 I)^-1 e, clamped to the joints' bounds.
"""

import math

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.vectors import dot
from remosplat_drake.robot.kinematics import REVOLUTE, compose, joint_pose
from remosplat_drake.robot.target_arrays import asked_rotation, has_free

_LENGTH = 0.3
"""Length by which angles of the pose error are weighed [m]."""

_LONGEST_STEP = 0.5
"""Largest change of a joint in one step [rad, m]."""


@kernel
def reach_from(chain, target, lower, upper, seeds, steps, tolerance):
    """Solves for configurations that bring E to T, from each of k seeds.

    Args:
        chain: The robot's joints as a `SerialChain`.
        target: The `TargetArrays`.
        lower: Lower bounds of q, shape (n_q,) [rad, m].
        upper: Upper bounds of q, shape (n_q,) [rad, m].
        seeds: Configurations to start from, shape (k, n_q); what carries the
            arm stays where it is.
        steps: Largest number of steps from a seed; with 0 the seeds' own
            errors are measured.
        tolerance: Error that is small enough, angles weighed by 0.3 m [m].

    Returns:
        Where each seed has led to, shape (k, n_q), and the errors there,
        shape (k,) [m].
    """
    q = seeds.copy()
    error = np.empty(len(q))
    first = len(chain.kind) - chain.arm
    X_WF = np.zeros((len(chain.kind), 4, 4))
    X_WE = np.zeros((4, 4))
    J = np.empty((6, chain.arm))
    e = np.empty(6)
    step = np.empty(chain.arm)
    L = np.zeros((6, 6))
    all_asked = not has_free(target.weights)
    for k in range(len(q)):
        damping = 0.05
        before = np.inf
        for i in range(steps + 1):
            _place(chain, q[k], X_WF, X_WE)
            _pose_error(X_WE, target.X_WT, e)
            if not all_asked:
                _leave_free_error(X_WE, target, e)
            size = 0.0
            for r in range(6):
                size += e[r] * e[r]
            size = math.sqrt(size)
            error[k] = size
            if size < tolerance or i == steps:
                break
            # A step that does not help was too bold.
            damping = 0.5 * damping if size < before else 4.0 * damping
            damping = min(max(damping, 1e-4), 0.5)
            before = size
            _jacobian(chain, X_WF, X_WE, J)
            if not all_asked:
                for j in range(chain.arm):
                    _leave_free(target, J[:, j])
            _damped_step(J, e, damping, L, step)
            longest = _LONGEST_STEP
            for j in range(chain.arm):
                longest = max(longest, abs(step[j]))
            scale = _LONGEST_STEP / longest
            for j in range(chain.arm):
                entry = chain.position[first + j]
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
def _leave_free_error(X_WE, target, e):
    """Fills in the weighed error in what is asked, in the axes of T."""
    turn_W = asked_rotation(X_WE, target.X_WT, target.weights)
    for c in range(3):
        e[c] = _LENGTH * turn_W[c]
    _leave_free(target, e)


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
def _jacobian(chain, X_WF, X_WE, J):
    """Fills in the Jacobian of the arm, angles weighed as in the error."""
    first = len(chain.kind) - chain.arm
    a = np.empty(3)
    for j in range(chain.arm):
        X, axis_F = X_WF[first + j], chain.axis_F[first + j]
        for r in range(3):
            a[r] = 0.0
            for c in range(3):
                a[r] += X[r, c] * axis_F[c]
        if chain.kind[first + j] == REVOLUTE:
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
def _damped_step(J, e, damping, L, step):
    """Fills in J' (J J' + damping^2 I)^-1 e, and the Cholesky factor L."""
    for r in range(6):
        for c in range(r + 1):
            total = damping * damping if r == c else 0.0
            for j in range(J.shape[1]):
                total += J[r, j] * J[c, j]
            for i in range(c):
                total -= L[r, i] * L[c, i]
            L[r, c] = math.sqrt(total) if r == c else total / L[c, c]
    x = np.empty(6)
    for r in range(6):
        x[r] = e[r]
        for i in range(r):
            x[r] -= L[r, i] * x[i]
        x[r] /= L[r, r]
    for r in range(5, -1, -1):
        for i in range(r + 1, 6):
            x[r] -= L[i, r] * x[i]
        x[r] /= L[r, r]
    for j in range(J.shape[1]):
        step[j] = 0.0
        for r in range(6):
            step[j] += J[r, j] * x[r]
