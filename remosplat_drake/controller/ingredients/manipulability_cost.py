"""Keep the arm away from singularities."""

import dataclasses as dc

import numpy as np
from numba import njit

from remosplat_drake.controller.reactive_program import ReactiveProgram, Tick


@dc.dataclass
class ManipulabilityCostConfig:
    """How eagerly the arm keeps its freedom of motion."""

    # Gain of the linear cost; 0 leaves it out.
    gain: float = 0.3


class ManipulabilityCost:
    """-gain times the gradient of Yoshikawa's measure on the arm.

    The paper's manipulability Jacobian J_m (eq. 6).
    """

    def __init__(self, config: ManipulabilityCostConfig):
        self._gain = config.gain

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        """Adds the cost."""
        if self._gain == 0.0:
            return
        arm = slice(tick.robot.n_base, None)
        _, gradient = manipulability(
            np.ascontiguousarray(tick.state.Jw_WE[:, arm]),
            np.ascontiguousarray(tick.state.Jv_WE[:, arm]),
        )
        c = np.zeros(len(program.u))
        c[arm] = -self._gain * gradient
        program.prog.AddLinearCost(
            c, 0.0, program.u
        ).evaluator().set_description("manipulability")


@njit(cache=True)
def manipulability(Jw, Jv):
    """Yoshikawa's m = sqrt(det(J J')) and its gradient over the joints.

    dm/dq_k = m tr((J J')^-1 dJ/dq_k J'), where the derivative of a geometric
    Jacobian follows from its own columns: a joint further in turns the
    column, a joint further out moves its tip.

    Args:
        Jw: Angular Jacobian, shape (3, n).
        Jv: Translational Jacobian, shape (3, n).

    Returns:
        m, and its gradient, shape (n,); both zero at a singularity.
    """
    n = Jw.shape[1]
    J = np.vstack((Jw, Jv))
    gradient = np.zeros(n)
    determinant = np.linalg.det(J @ J.T)
    if n < 6 or determinant < 1e-18:
        return 0.0, gradient
    m = np.sqrt(determinant)
    pseudo_inverse = np.linalg.solve(J @ J.T, J)  # (J J')^-1 J
    for k in range(n):
        total = 0.0
        for j in range(n):
            if k <= j:
                dw = np.cross(Jw[:, k], Jw[:, j])
                dv = np.cross(Jw[:, k], Jv[:, j])
            else:
                dw = np.zeros(3)
                dv = np.cross(Jw[:, j], Jv[:, k])
            for r in range(3):
                total += dw[r] * pseudo_inverse[r, j]
                total += dv[r] * pseudo_inverse[r + 3, j]
        gradient[k] = m * total
    return m, gradient
