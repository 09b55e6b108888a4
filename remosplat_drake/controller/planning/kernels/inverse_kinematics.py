"""Computes inverse kinematics of arms from eight seeds, and manipulability.

The method is damped least squares (Wampler 1986, Nakamura and Hanafusa 1986):
each step is J' (J J' + lambda^2 I)^-1 e, clamped to the bounds of the joints.
SIMD lanes contain the eight configurations. Each configuration has a separate
damping lambda, and its iteration ends separately.
"""

from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.base.kernels.returns import NOTHING, reals
from remosplat_drake.base.lanes import (
    WIDTH,
    greatest,
    in_all,
    lanes_from,
    least,
    magnitude,
    places_of,
    root,
    where,
    write_lanes,
)
from remosplat_drake.robot.kinematics import REVOLUTE
from remosplat_drake.robot.pose_lanes import (
    compose_by_lanes,
    entry,
    move_by_lanes,
    write_identity,
)
from remosplat_drake.robot.serial_chain import SerialChain
from remosplat_drake.robot.target_arrays import (
    AimArrays,
    constrained_rotation,
    has_free,
    target_of,
)

_LENGTH = 0.3
"""Length by which angles of the pose error are multiplied [m]."""

_LONGEST_STEP = 0.5
"""Largest change of a joint in one step [rad, m]."""

_DOUBT = 8
"""Number of steps after which the iteration ends if the error is still large.
Nine in ten of the seeds that reach the targets have a smaller error after this
number of steps."""

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

    chains: tuple[SerialChain | Packed[SerialChain], ...]
    aim: AimArrays | Packed[AimArrays]
    first: int
    lower: np.ndarray
    upper: np.ndarray


@kernel(returns=NOTHING)
def reach_from(arms, q, steps, tolerance, error):
    """Solves for configurations with each end effector at its target.

    Args:
        arms: The `Arms`.
        q: Input: eight seeds. Output: the final configurations, shape (n_q, 8)
            [rad, m]. The entries of the base do not change.
        steps: Largest number of steps. With 0, only the errors of the seeds are
            computed.
        tolerance: Error at which the iteration ends, with angles times 0.3 m
            [m].
        error: Output: the final errors, with angles times 0.3 m, shape (8,)
            [m].
    """
    aim, n = arms.aim, len(q) - arms.first
    rows = 6 * len(aim.effector)
    X, E = np.zeros((len(q) + 1, 3, 4, WIDTH)), np.zeros((1, 3, 4, WIDTH))
    J, e = np.zeros((rows, n, WIDTH)), np.zeros((rows, WIDTH))
    L, x = np.zeros((rows, rows, WIDTH)), np.zeros((rows, WIDTH))
    step = np.zeros((n, WIDTH))
    damping, before = in_all(0.05), in_all(np.inf)
    for i in range(steps + 1):
        for c in range(len(aim.effector)):
            chain = arms.chains[aim.effector[c]]
            _place(chain, q, X, E)
            _write_error(E, target_of(aim, c), e, 6 * c)
            if i < steps:
                _write_jacobian(chain, arms.first, X, E, J, 6 * c)
                _leave_columns(target_of(aim, c), J, 6 * c)
        square = in_all(0.0)
        for r in range(rows):
            square = square + _row(e, r) * _row(e, r)
        now = root(square)
        write_lanes(error, 0, now)
        is_open = now >= tolerance
        if i >= _DOUBT:
            is_open = is_open & (now <= _HOPELESS)
        if i == steps or places_of(is_open) == 0:
            break
        # If a step did not reduce the error, it was too large.
        damping = where(now < before, 0.5 * damping, 4.0 * damping)
        damping = least(greatest(damping, 1e-4), 0.5)
        before = now
        _write_step(J, e, damping, L, x, step)
        longest = in_all(_LONGEST_STEP)
        for j in range(n):
            longest = greatest(longest, magnitude(_row(step, j)))
        scale = where(is_open, _LONGEST_STEP / longest, 0.0)
        for j in range(n):
            k = arms.first + j
            value = _row(q, k) + scale * _row(step, j)
            value = least(greatest(value, arms.lower[k]), arms.upper[k])
            _write_row(q, k, value)


@kernel(returns=reals(1))
def least_manipulability(arms, q):
    """Returns the least manipulability sqrt(det(J J')) of the arms.

    The measure is Yoshikawa's (1985). For an arm with fewer than six joints, it
    counts as 1.

    Args:
        arms: The `Arms`.
        q: Configurations, shape (k, n_q) [rad, m].

    Returns:
        The least manipulability in each configuration, shape (k,).
    """
    aim, n, found = arms.aim, q.shape[1] - arms.first, np.full(len(q), np.inf)
    if n < 6:
        found[:] = 1.0
        return found
    X, E = np.zeros((q.shape[1] + 1, 3, 4, WIDTH)), np.zeros((1, 3, 4, WIDTH))
    J, L = np.zeros((6, n, WIDTH)), np.zeros((6, 6, WIDTH))
    some, product = np.zeros((q.shape[1], WIDTH)), np.zeros(WIDTH)
    for first in range(0, len(q), WIDTH):
        count = min(WIDTH, len(q) - first)
        for k in range(count):
            some[:, k] = q[first + k]
        for c in range(len(aim.effector)):
            chain = arms.chains[aim.effector[c]]
            _place(chain, some, X, E)
            J[:] = 0.0
            _write_jacobian(chain, arms.first, X, E, J, 0)
            _factor(J, in_all(_NO_DAMPING), L)
            root_of_det = in_all(1.0 / _LENGTH**3)
            for r in range(6):
                root_of_det = root_of_det * _cell(L, r, r)
            write_lanes(product, 0, root_of_det)
            for k in range(count):
                found[first + k] = min(found[first + k], product[k])
    return found


@helper
def _row(array, i):
    """Returns a row of an array of shape (n, 8), as lanes."""
    return lanes_from(array, i * WIDTH)


@helper
def _write_row(array, i, value):
    """Writes a row of an array of shape (n, 8)."""
    write_lanes(array, i * WIDTH, value)


@helper
def _cell(array, i, j):
    """Returns a cell of an array of shape (n, m, 8), as lanes."""
    return lanes_from(array, (i * array.shape[1] + j) * WIDTH)


@helper
def _write_cell(array, i, j, value):
    """Writes a cell of an array of shape (n, m, 8)."""
    write_lanes(array, (i * array.shape[1] + j) * WIDTH, value)


@helper
def _place(chain, q, X_WF, X_WE):
    """Writes the poses of the joints' inboard frames and of E.

    The last pose of X_WF is scratch memory.
    """
    last = len(X_WF) - 1
    write_identity(X_WF, last)
    for j in range(len(chain.kind)):
        compose_by_lanes(X_WF, last, chain.X_MF[j], X_WF, j)
        kind, axis_F = chain.kind[j], chain.axis_F[j]
        value = _row(q, chain.position[j])
        move_by_lanes(kind, axis_F, value, X_WF, j, X_WF, last)
    compose_by_lanes(X_WF, last, chain.X_ME, X_WE, 0)


@helper
def _write_error(X_WE, target, e, first):
    """Writes the weighted error in the constrained directions."""
    X_WT = target.X_WT
    for r in range(3):
        _write_row(e, first + 3 + r, X_WT[r, 3] - entry(X_WE, 0, r, 3))
    if not has_free(target.weights):
        _write_turn(X_WE, X_WT, e, first)
        return
    X = np.eye(4)
    for k in range(WIDTH):
        for r in range(3):
            for c in range(4):
                X[r, c] = X_WE[0, r, c, k]
        turn_W = constrained_rotation(X, X_WT, target.weights)
        for c in range(3):
            e[first + c, k] = _LENGTH * turn_W[c]
    for half in (0, 3):
        at = first + half
        v = _row(e, at), _row(e, at + 1), _row(e, at + 2)
        for axis in range(3):
            _write_row(e, at + axis, _along(target, half, axis, v))


@helper
def _write_turn(X_WE, X_WT, e, first):
    """Writes the weighted rotation from E to T, in W.

    For a rotation by the angle x, the result is the axis times 2 sin(x / 2). It
    needs no arc tangent, and is nearly the axis times x if x is small.
    """
    trace = in_all(0.0)
    for r in range(3):
        for k in range(3):
            trace = trace + X_WT[r, k] * entry(X_WE, 0, r, k)
    # This is 1 + cos(x) = 2 cos(x / 2)^2. The axis is multiplied by sin(x).
    above = greatest(0.5 * (trace + 1.0), 1e-9)
    factor = _LENGTH * root(2.0 / above)
    _write_row(e, first, factor * _turn(X_WE, X_WT, 2, 1))
    _write_row(e, first + 1, factor * _turn(X_WE, X_WT, 0, 2))
    _write_row(e, first + 2, factor * _turn(X_WE, X_WT, 1, 0))


@helper
def _turn(X_WE, X_WT, r, c):
    """Returns an entry of the axis times the sine of the angle, as lanes."""
    total = in_all(0.0)
    for k in range(3):
        total = total + X_WT[r, k] * entry(X_WE, 0, c, k)
        total = total - X_WT[c, k] * entry(X_WE, 0, r, k)
    return 0.5 * total


@helper
def _along(target, half, axis, v):
    """Returns a vector's entry along an axis of T; zero in free directions."""
    if target.weights[half + axis] == 0.0:
        return in_all(0.0)
    X_WT = target.X_WT
    return v[0] * X_WT[0, axis] + v[1] * X_WT[1, axis] + v[2] * X_WT[2, axis]


@helper
def _leave_columns(target, J, first):
    """Removes the free directions from a Jacobian."""
    if not has_free(target.weights):
        return
    for j in range(J.shape[1]):
        for half in (0, 3):
            at = first + half
            v = _cell(J, at, j), _cell(J, at + 1, j), _cell(J, at + 2, j)
            for axis in range(3):
                _write_cell(J, at + axis, j, _along(target, half, axis, v))


@helper
def _write_jacobian(chain, first, X_WF, X_WE, J, row):
    """Writes the Jacobian of a pose, with angles weighted as in the error.

    Its columns belong to the arms' joints. The columns of joints that do not
    move E are not written.
    """
    for i in range(len(chain.kind)):
        j = chain.position[i] - first
        if j < 0:
            continue
        x, y, z = chain.axis_F[i, 0], chain.axis_F[i, 1], chain.axis_F[i, 2]
        a = _axis(X_WF, i, 0, x, y, z)
        b = _axis(X_WF, i, 1, x, y, z)
        c = _axis(X_WF, i, 2, x, y, z)
        if chain.kind[i] == REVOLUTE:
            dx = entry(X_WE, 0, 0, 3) - entry(X_WF, i, 0, 3)
            dy = entry(X_WE, 0, 1, 3) - entry(X_WF, i, 1, 3)
            dz = entry(X_WE, 0, 2, 3) - entry(X_WF, i, 2, 3)
            _write_cell(J, row, j, _LENGTH * a)
            _write_cell(J, row + 1, j, _LENGTH * b)
            _write_cell(J, row + 2, j, _LENGTH * c)
            _write_cell(J, row + 3, j, b * dz - c * dy)
            _write_cell(J, row + 4, j, c * dx - a * dz)
            _write_cell(J, row + 5, j, a * dy - b * dx)
        else:
            for r in range(3):
                _write_cell(J, row + r, j, in_all(0.0))
            _write_cell(J, row + 3, j, a)
            _write_cell(J, row + 4, j, b)
            _write_cell(J, row + 5, j, c)


@helper
def _axis(X, i, r, x, y, z):
    """Returns an entry of a joint's axis in W, as lanes."""
    return entry(X, i, r, 0) * x + entry(X, i, r, 1) * y + entry(X, i, r, 2) * z


@helper
def _factor(J, damping, L):
    """Writes the Cholesky factor L of J J' + damping^2 I."""
    for r in range(len(J)):
        for c in range(r + 1):
            total = in_all(0.0)
            for j in range(J.shape[1]):
                total = total + _cell(J, r, j) * _cell(J, c, j)
            for i in range(c):
                total = total - _cell(L, r, i) * _cell(L, c, i)
            if r == c:
                # The maximum prevents a square that is negative because of
                # rounding.
                square = damping * damping
                total = root(greatest(total + square, 0.25 * square))
            else:
                total = total / _cell(L, c, c)
            _write_cell(L, r, c, total)


@helper
def _write_step(J, e, damping, L, x, step):
    """Writes J' (J J' + damping^2 I)^-1 e, with L and x as working memory."""
    rows = len(e)
    _factor(J, damping, L)
    for r in range(rows):
        total = _row(e, r)
        for i in range(r):
            total = total - _cell(L, r, i) * _row(x, i)
        _write_row(x, r, total / _cell(L, r, r))
    for r in range(rows - 1, -1, -1):
        total = _row(x, r)
        for i in range(r + 1, rows):
            total = total - _cell(L, i, r) * _row(x, i)
        _write_row(x, r, total / _cell(L, r, r))
    for j in range(J.shape[1]):
        total = in_all(0.0)
        for r in range(rows):
            total = total + _cell(J, r, j) * _row(x, r)
        _write_row(step, j, total)
