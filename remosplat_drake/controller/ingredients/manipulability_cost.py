"""Manipulability cost: keeps the arm away from singularities."""

import dataclasses as dc
from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import NOTHING, REAL, reals, several
from remosplat_drake.base.ranges import Config
from remosplat_drake.base.vectors import cross, dot
from remosplat_drake.controller.program.compiled_ingredient import (
    CompiledIngredient,
)
from remosplat_drake.robot.robot_model import RobotModel


@dc.dataclass
class ManipulabilityCostConfig(Config):
    """Settings of the cost that keeps the arm away from singularities."""

    # Gain k_m of the linear cost; 0 omits the cost.
    gain: Annotated[float, Interval(ge=0, le=100)] = 0.3


class ManipulabilityCost(CompiledIngredient):
    """A linear cost that keeps the arm away from singularities (J_m).

    `add_manipulability_cost` computes it.

    Args:
        config: Gain k_m of the cost.
    """

    term = "manipulability"

    def __init__(self, config: ManipulabilityCostConfig):
        self._gain = config.gain

    def settings(self, robot: RobotModel) -> "ManipulabilitySettings":
        """Makes the input of the kernel; see `CompiledIngredient`."""
        return ManipulabilitySettings(self._gain)


class ManipulabilitySettings(NamedTuple):
    """Settings of a `ManipulabilityCost` for kernels."""

    gain: float


@kernel(returns=NOTHING)
def add_manipulability_cost(own, k, tick, program):
    """Adds a linear cost that keeps the arm away from singularities.

    The arm's joint rates have the cost c'u_arm with

        c = -k_m grad m,    m = sqrt(det(J J'))

    (paper eq. 6, J_m; Yoshikawa 1985). J consists of the arm's columns of the
    end effector's Jacobian in W, angular before translational. The gradient is
    with respect to the arm's joint positions; see `manipulability`. For an arm
    with fewer than six joints, there is no cost. Each end effector that has a
    target adds a cost. On a planned path, there is no cost.

    See `CompiledIngredient` for the arguments.
    """
    if own.gain == 0.0 or len(tick.guidance.path_s):
        return
    state, n = tick.state, tick.robot.n_base
    n_arm = len(tick.u_previous) - n
    Jw, Jv = np.empty((3, n_arm)), np.empty((3, n_arm))
    program.has[k, 0] = True
    for i in tick.aim.effector:
        for r in range(3):
            for j in range(n_arm):
                Jw[r, j] = state.Jw_WE[i, r, n + j]
                Jv[r, j] = state.Jv_WE[i, r, n + j]
        _, gradient = manipulability(Jw, Jv)
        for j in range(n_arm):
            program.linear[k, n + j] -= own.gain * gradient[j]


@kernel(returns=several(REAL, reals(1)))
def manipulability(Jw, Jv):
    """Computes the manipulability m = sqrt(det(J J')) and its gradient.

    The measure is Yoshikawa's (1985). Its gradient is dm/dq_k = m tr((J J')^-1
    dJ/dq_k J'). The derivative of a geometric Jacobian can be computed from its
    columns: a joint nearer to the base rotates the column, and a joint nearer
    to the end effector moves the end effector relative to the column's axis.

    Args:
        Jw: Angular Jacobian of the end effector, shape (3, n).
        Jv: Translational Jacobian of the end effector, shape (3, n) [m].

    Returns:
        The manipulability m, and its gradient with respect to the n joints,
        shape (n,). Both are zero at a singularity, and for fewer than six
        joints.
    """
    n = Jw.shape[1]
    J, gradient = np.empty((6, n)), np.zeros(n)
    for r in range(3):
        for j in range(n):
            J[r, j], J[3 + r, j] = Jw[r, j], Jv[r, j]
    L = _cholesky(J)
    m = 1.0
    for r in range(6):
        m *= L[r, r]
    if n < 6 or m < 1e-9:
        return 0.0, gradient
    P = _solve(L, J)  # (J J')^-1 J
    for k in range(n):
        total = 0.0
        for j in range(n):
            if k <= j:
                total += dot(cross(Jw[:, k], Jw[:, j]), P[:3, j])
                total += dot(cross(Jw[:, k], Jv[:, j]), P[3:, j])
            else:
                total += dot(cross(Jw[:, j], Jv[:, k]), P[3:, j])
        gradient[k] = m * total
    return m, gradient


@helper
def _cholesky(J):
    """Returns the Cholesky factor L of J J', a lower triangular matrix.

    If a row of J depends linearly on the rows before it, the diagonal entry and
    the entries below it are zero. NumPy's function is not used, since Numba
    takes seconds to compile it.
    """
    rows = len(J)  # Not 6: compilers would unroll all loops.
    L = np.zeros((rows, rows))
    for r in range(rows):
        for c in range(r + 1):
            total = 0.0
            for j in range(J.shape[1]):
                total += J[r, j] * J[c, j]
            for i in range(c):
                total -= L[r, i] * L[c, i]
            if r == c:
                L[r, r] = np.sqrt(max(total, 0.0))
            elif L[c, c] > 0.0:
                L[r, c] = total / L[c, c]
    return L


@helper
def _solve(L, J):
    """Returns (L L')^-1 J, by forward and backward substitution."""
    P = J.copy()
    for j in range(J.shape[1]):
        for r in range(len(L)):
            for i in range(r):
                P[r, j] -= L[r, i] * P[i, j]
            P[r, j] /= L[r, r]
        for r in range(len(L) - 1, -1, -1):
            for i in range(r + 1, len(L)):
                P[r, j] -= L[i, r] * P[i, j]
            P[r, j] /= L[r, r]
    return P
