"""A tick's quadratic program as plain data."""

import dataclasses as dc
from collections.abc import Callable
from functools import cached_property

import numpy as np

from remosplat_drake.controller.active_set import DenseProgram
from remosplat_drake.controller.slack_form import SlackForm

Label = Callable[[int], str | tuple[str, ...]]
"""Says what a row is about, by its number: names of links or joints, or a
text."""


def names_of(said: str | tuple[str, ...]) -> tuple[str, ...]:
    """Returns what a row is about as names: a text is one of them.

    Args:
        said: What a `Label` has said.
    """
    return (said,) if isinstance(said, str) else said


def row_name(term: str, about: tuple[str, ...]) -> str:
    """Names a row for people.

    Args:
        term: Name of its set of rows.
        about: What it is about.
    """
    return f"{term}[{' and '.join(about)}]"


@dc.dataclass(frozen=True, eq=False)
class Rows:
    """All inequality rows A u <= b of one ingredient.

    Attributes:
        A: Coefficients of the rows, shape (m, n_u).
        b: Right-hand sides of the rows, shape (m,).
        kept: Which rows are in the program, shape (m,) bool; the bounds on u
            imply the others.
        label: Says what row i is about: names of links or joints, or a text.
    """

    A: np.ndarray
    b: np.ndarray
    kept: np.ndarray
    label: Label = "row {}".format

    def about(self, i: int) -> tuple[str, ...]:
        """Returns what row i is about, as names or a text."""
        return names_of(self.label(i))

    def yielding(self, name: str) -> list[str]:
        """Says which rows demand a retreat, under a name for all of them."""
        rows = np.flatnonzero(self.b < 0).tolist()
        return [row_name(name, self.about(i)) for i in rows]


@dc.dataclass(frozen=True, eq=False)
class Tracking:
    """J u + delta = V with the cost |delta|^2 price / 2 (paper eq. 2).

    Attributes:
        name: The name of this tracking in the program.
        J: Jacobian of the end effector in W, angular above translational, in
            the r directions that are tracked, shape (r, n_u).
        V: The wanted twist V_WE in these, shape (r,) [rad/s, m/s].
        price: Weight of the squared slack delta in the cost.
        limit: Bounds on |delta|, shape (r,) [rad/s, m/s].
    """

    name: str
    J: np.ndarray
    V: np.ndarray
    price: float
    limit: np.ndarray


def tracking_name(term: str, effector: str) -> str:
    """Returns what the tracking of an end effector's twist is called.

    Args:
        term: Name of what tracks it.
        effector: Name of the end effector; an only one has none.
    """
    return f"{term} {effector}".rstrip()


@dc.dataclass(eq=False)
class Terms:
    """The terms of a program, by their names.

    Attributes:
        rows: Inequality rows A u <= b.
        linear: Vectors c of linear costs c'u, shape (n_u,) each.
        quadratic: Diagonals w of quadratic costs u' diag(w) u / 2, shape
            (n_u,) each.
        trackings: How the end effectors' twists are tracked.
    """

    rows: dict[str, Rows] = dc.field(default_factory=dict)
    linear: dict[str, np.ndarray] = dc.field(default_factory=dict)
    quadratic: dict[str, np.ndarray] = dc.field(default_factory=dict)
    trackings: dict[str, Tracking] = dc.field(default_factory=dict)

    def copy(self) -> "Terms":
        """Returns the same terms, to which others can be added."""
        return Terms(
            dict(self.rows),
            dict(self.linear),
            dict(self.quadratic),
            dict(self.trackings),
        )


class ProgramData:
    """Costs, bounds and rows in the command u and the slack delta.

    The command has n_u entries, the slack one for each direction in which an
    end effector's twist is tracked, six at most each.

    Args:
        velocity_limit: Bounds on |u| to begin with, shape (n_u,) [rad/s, m/s].

    Attributes:
        lower: Lower bounds on u, shape (n_u,); ingredients may only raise
            them.
        upper: Upper bounds on u, shape (n_u,); ingredients may only lower
            them.
        terms: Costs, rows and trackings.
    """

    def __init__(self, velocity_limit: np.ndarray):
        self.lower, self.upper = -velocity_limit, velocity_limit

    @cached_property
    def terms(self) -> Terms:
        """Costs, rows and trackings, to which ingredients add."""
        return Terms()

    @property
    def rows(self) -> dict[str, Rows]:
        """Inequality rows A u <= b by name."""
        return self.terms.rows

    @property
    def linear(self) -> dict[str, np.ndarray]:
        """Vectors c of linear costs c'u by name, shape (n_u,) each."""
        return self.terms.linear

    @property
    def quadratic(self) -> dict[str, np.ndarray]:
        """Diagonals w of costs u' diag(w) u / 2 by name, shape (n_u,) each."""
        return self.terms.quadratic

    @property
    def trackings(self) -> dict[str, Tracking]:
        """How the end effectors' twists are tracked, by name."""
        return self.terms.trackings

    @property
    def tracking(self) -> Tracking | None:
        """How the first of the end effectors' twists is tracked, if any is."""
        return next(iter(self.trackings.values()), None)

    @property
    def n_u(self) -> int:
        """Number of entries of the command u."""
        return len(self.lower)

    @property
    def weights(self) -> np.ndarray:
        """The diagonal of all quadratic costs together, shape (n_u,)."""
        return sum(self.quadratic.values(), np.zeros(self.n_u))

    @property
    def slope(self) -> np.ndarray:
        """The vector of all linear costs together, shape (n_u,)."""
        return sum(self.linear.values(), np.zeros(self.n_u))

    def dense(self) -> DenseProgram:
        """Returns the program in u alone, its slack replaced by V - J u."""
        H, c = np.diag(self.weights), self.slope
        eye = np.eye(self.n_u)
        A = [eye, -eye, *(rows.A[rows.kept] for rows in self.rows.values())]
        b = [self.upper, -self.lower]
        b += [rows.b[rows.kept] for rows in self.rows.values()]
        bounds: list[tuple[np.ndarray, np.ndarray]] = []
        for tracking in self.trackings.values():
            J, V, limit = tracking.J, tracking.V, tracking.limit
            H += tracking.price * J.T @ J
            c = c - tracking.price * V @ J
            bounds += [(J, limit + V)]
        for tracking in self.trackings.values():
            J, V, limit = tracking.J, tracking.V, tracking.limit
            bounds += [(-J, limit - V)]
        for slack_A, slack_b in bounds:
            kept = self.can_bind(slack_A, slack_b)
            A.append(slack_A[kept])
            b.append(slack_b[kept])
        return DenseProgram(H, c, np.concatenate(A), np.concatenate(b))

    def kept(self, name: str) -> np.ndarray:
        """Returns which of a set's rows are in the program, shape (m,), bool.

        Args:
            name: Name of the set, which has no rows where there is none.
        """
        rows = self.rows.get(name)
        return np.zeros(0, bool) if rows is None else rows.kept

    def slack_form(self) -> SlackForm:
        """Returns the program with its slack, as few terms as it takes."""
        n_u, rows = self.n_u, self.rows.values()
        trackings = self.trackings.values()
        J = np.concatenate([np.zeros((0, n_u)), *(t.J for t in trackings)])
        V = np.concatenate([np.zeros(0), *(t.V for t in trackings)])
        limit = np.concatenate([np.zeros(0), *(t.limit for t in trackings)])
        prices = [np.full(len(t.V), t.price) for t in trackings]
        is_low = self.can_bind(J, limit + V)
        is_high = self.can_bind(-J, limit - V)
        A = [np.zeros((0, n_u)), *(r.A[r.kept] for r in rows)]
        b = [np.zeros(0), *(r.b[r.kept] for r in rows)]
        return SlackForm(
            self.lower,
            self.upper,
            np.where(is_low, -limit, -np.inf),
            np.where(is_high, limit, np.inf),
            np.concatenate(A),
            np.concatenate(b),
            np.hstack([J, np.eye(len(V))]),
            V,
            np.diag(np.concatenate([self.weights, *prices])),
            np.concatenate([self.slope, np.zeros(len(V))]),
        )

    def tight_rows(
        self, u: np.ndarray, tolerance: float
    ) -> list[tuple[str, int]]:
        """Finds the rows that are kept and hold with equality.

        Args:
            u: A command, shape (n_u,).
            tolerance: By how much less than b a row may be [m/s, rad/s].

        Returns:
            The name of each one's set, and its number in that.
        """
        return [
            (name, i)
            for name, rows in self.rows.items()
            for i in np.flatnonzero(
                rows.kept & (rows.A @ u >= rows.b - tolerance)
            ).tolist()
        ]

    def can_bind(self, A: np.ndarray, b: np.ndarray) -> np.ndarray:
        """Finds the rows A u <= b that the bounds on u do not imply.

        Args:
            A: Coefficients of the rows, shape (m, n_u).
            b: Right-hand sides of the rows, shape (m,).

        Returns:
            True for the rows that may bind, shape (m,) bool.
        """
        center = 0.5 * (self.upper + self.lower)
        radius = 0.5 * (self.upper - self.lower)
        # NaN is kept: no row is ever dropped because a number is missing.
        return ~(A @ center + np.abs(A) @ radius <= b)

    def excess(self, A: np.ndarray, b: np.ndarray) -> float:
        """Measures by how much rows are violated at least within the bounds.

        Args:
            A: Coefficients of the rows A u <= b, shape (m, n_u).
            b: Right-hand sides of the rows, shape (m,).

        Returns:
            The excess of the worst row [m/s, rad/s]; not above 0 where each
            row can hold.
        """
        center = 0.5 * (self.upper + self.lower)
        radius = 0.5 * (self.upper - self.lower)
        return (A @ center - np.abs(A) @ radius - b).max(initial=0.0)
