"""Inverse kinematics of an arm from many seeds, in one compiled loop.

Damped least squares (Wampler 1986, Nakamura and Hanafusa 1986): each step is
J' (J J' + lambda^2 I)^-1 e, clamped to the joints' bounds.
"""

import math

import numpy as np
from numba import njit

from remosplat_drake.robot.kinematics import REVOLUTE, body_poses

_LENGTH = 0.3
"""Length by which angles of the pose error are weighed [m]."""

_LONGEST_STEP = 0.5
"""Largest change of a joint in one step [rad, m]."""


@njit(cache=True)
def reach_from(
    tree, body_E, X_LE, X_WT, joints, lower, upper, seeds, steps, tolerance
):
    """Solves for configurations that bring E to T, from each of k seeds.

    Args:
        tree: The arguments of `kinematics.body_poses` before q.
        body_E: Index of the body that carries the end effector.
        X_LE: Pose of the end effector E in that body, shape (4, 4).
        X_WT: Pose of the target T in W, shape (4, 4).
        joints: Bodies that the arm's joints move, in the order of q's last
            entries, shape (n_arm,).
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
    n = len(joints)
    first = q.shape[1] - n
    J = np.empty((6, n))
    e = np.empty(6)
    step = np.empty(n)
    for k in range(len(q)):
        damping = 0.05
        before = np.inf
        for i in range(steps + 1):
            X_WL, X_WF = body_poses(*tree, q[k])  # pyright: ignore
            _error_and_jacobian(
                tree, X_WL[body_E], X_WF, X_LE, X_WT, joints, e, J
            )
            size = math.sqrt(np.sum(e * e))
            error[k] = size
            if size < tolerance or i == steps:
                break
            # A step that does not help was too bold.
            damping = 0.5 * damping if size < before else 4.0 * damping
            damping = min(max(damping, 1e-4), 0.5)
            before = size
            _damped_step(J, e, damping, step)
            longest = np.abs(step).max()
            scale = min(1.0, _LONGEST_STEP / longest)
            for j in range(n):
                value = q[k, first + j] + scale * step[j]
                value = min(max(value, lower[first + j]), upper[first + j])
                q[k, first + j] = value
    return q, error


@njit(cache=True)
def _error_and_jacobian(tree, X_WL, X_WF, X_LE, X_WT, joints, e, J):
    """Fills in the weighed pose error e and the Jacobian of the arm J."""
    p = np.empty(3)
    R = np.zeros((3, 3))  # From E to T, in W.
    for r in range(3):
        p[r] = X_WL[r, 3]
        for c in range(3):
            p[r] += X_WL[r, c] * X_LE[c, 3]
    R_WE = np.empty((3, 3))
    for r in range(3):
        for c in range(3):
            R_WE[r, c] = 0.0
            for k in range(3):
                R_WE[r, c] += X_WL[r, k] * X_LE[k, c]
    for r in range(3):
        for c in range(3):
            for k in range(3):
                R[r, c] += X_WT[r, k] * R_WE[c, k]
    x = 0.5 * (R[2, 1] - R[1, 2])
    y = 0.5 * (R[0, 2] - R[2, 0])
    z = 0.5 * (R[1, 0] - R[0, 1])
    sine = math.sqrt(x * x + y * y + z * z)
    cosine = 0.5 * (R[0, 0] + R[1, 1] + R[2, 2] - 1.0)
    factor = 1.0
    if sine > 1e-9:
        factor = math.atan2(sine, cosine) / sine
    for r in range(3):
        e[3 + r] = X_WT[r, 3] - p[r]
    e[0] = _LENGTH * factor * x
    e[1] = _LENGTH * factor * y
    e[2] = _LENGTH * factor * z
    kind, axis_F = tree[1], tree[2]
    for j in range(len(joints)):
        body = joints[j]
        X = X_WF[body]
        a = np.empty(3)
        for r in range(3):
            a[r] = 0.0
            for c in range(3):
                a[r] += X[r, c] * axis_F[body, c]
        if kind[body] == REVOLUTE:
            dx, dy, dz = p[0] - X[0, 3], p[1] - X[1, 3], p[2] - X[2, 3]
            for r in range(3):
                J[r, j] = _LENGTH * a[r]
            J[3, j] = a[1] * dz - a[2] * dy
            J[4, j] = a[2] * dx - a[0] * dz
            J[5, j] = a[0] * dy - a[1] * dx
        else:
            for r in range(3):
                J[r, j] = 0.0
                J[3 + r, j] = a[r]


@njit(cache=True)
def _damped_step(J, e, damping, step):
    """Fills in J' (J J' + damping^2 I)^-1 e."""
    L = np.zeros((6, 6))
    for r in range(6):
        for c in range(r + 1):
            total = damping * damping if r == c else 0.0
            for j in range(J.shape[1]):
                total += J[r, j] * J[c, j]
            for i in range(c):
                total -= L[r, i] * L[c, i]
            L[r, c] = math.sqrt(total) if r == c else total / L[c, c]
    x = e.copy()
    for r in range(6):
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
