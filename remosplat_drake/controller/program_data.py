"""A tick's quadratic program as plain data."""

import dataclasses as dc

import numpy as np

from remosplat_drake.controller.active_set import DenseProgram


@dc.dataclass(frozen=True, eq=False)
class Rows:
    """Inequality rows A u <= b of one ingredient, all of them.

    Attributes:
        A: Shape (m, n_u).
        b: Shape (m,).
        kept: The rows that are in the program, shape (m,) bool; the bounds
            on u imply the others.
    """

    A: np.ndarray
    b: np.ndarray
    kept: np.ndarray


@dc.dataclass(frozen=True, eq=False)
class Tracking:
    """J u + delta = V with the cost |delta|^2 price / 2 and bounds on delta.

    Attributes:
        name: Of the ingredient that tracks.
        J: Jacobian of the end effector (angular, translational), (6, n_u).
        V: Wanted twist, shape (6,).
        price: Of the squared slack delta.
        limit: Bounds on |delta|, shape (6,).
    """

    name: str
    J: np.ndarray
    V: np.ndarray
    price: float
    limit: np.ndarray


class ProgramData:
    """Costs, bounds and rows in u (n_u) and the slack delta (6).

    Attributes:
        lower: Bounds on u, shape (n_u,); ingredients may only narrow them.
        upper: See `lower`.
        rows: Inequality rows by ingredient name.
        linear: Linear costs c'u by ingredient name, shape (n_u,) each.
        quadratic: Diagonals W of costs u'Wu / 2, by ingredient name.
        tracking: Of the end effector's twist, if any.
    """

    def __init__(self, velocity_limit: np.ndarray):
        self.lower, self.upper = -velocity_limit, velocity_limit
        self.rows: dict[str, Rows] = {}
        self.linear: dict[str, np.ndarray] = {}
        self.quadratic: dict[str, np.ndarray] = {}
        self.tracking: Tracking | None = None

    @property
    def n_u(self) -> int:
        """Length of the command."""
        return len(self.lower)

    def narrow(self, lower: np.ndarray, upper: np.ndarray):
        """Bounds u by lower <= u <= upper, besides the present bounds."""
        self.lower = np.maximum(self.lower, lower)
        self.upper = np.minimum(self.upper, upper)

    def dense(self) -> DenseProgram:
        """The program in u alone: the slack is V - J u."""
        tracking = self.tracking
        H = np.diag(sum(self.quadratic.values(), np.zeros(self.n_u)))
        c = sum(self.linear.values(), np.zeros(self.n_u))
        eye = np.eye(self.n_u)
        A = [eye, -eye, *(rows.A[rows.kept] for rows in self.rows.values())]
        b = [self.upper, -self.lower]
        b += [rows.b[rows.kept] for rows in self.rows.values()]
        if tracking is not None:
            J, V, limit = tracking.J, tracking.V, tracking.limit
            H += tracking.price * J.T @ J
            c = c - tracking.price * V @ J
            slack_A = np.concatenate([J, -J])
            slack_b = np.concatenate([limit + V, limit - V])
            kept = self.can_bind(slack_A, slack_b)
            A.append(slack_A[kept])
            b.append(slack_b[kept])
        return DenseProgram(H, c, np.concatenate(A), np.concatenate(b))

    def can_bind(self, A: np.ndarray, b: np.ndarray) -> np.ndarray:
        """Which rows A u <= b the bounds on u do not imply, (m,) bool."""
        center = 0.5 * (self.upper + self.lower)
        radius = 0.5 * (self.upper - self.lower)
        return A @ center + np.abs(A) @ radius > b
