"""The terms of a tick's quadratic program, keyed by name."""

import dataclasses as dc
from collections.abc import Callable

import numpy as np

Label = Callable[[int], str | tuple[str, ...]]
"""Function that returns the subject of a row, given its index. The subject is
the names of links or joints, or a text."""


def names_of(said: str | tuple[str, ...]) -> tuple[str, ...]:
    """Returns the subject of a row as a tuple of names; a text is one name.

    Args:
        said: The subject of the row, which a `Label` has returned.
    """
    return (said,) if isinstance(said, str) else said


def row_name(term: str, about: tuple[str, ...]) -> str:
    """Returns the name of a row for display.

    Args:
        term: Name of the set of rows that contains the row.
        about: Subject of the row.
    """
    return f"{term}[{' and '.join(about)}]"


@dc.dataclass(frozen=True, eq=False)
class Rows:
    """The inequality rows A u <= b of one ingredient.

    Attributes:
        A: Coefficients of the rows, shape (m, n_u).
        b: Right-hand sides of the rows, shape (m,).
        kept: Whether each row is in the program, shape (m,), bool. The bounds
            of u imply all other rows.
        label: Function that returns the subject of row i: links or joints, or a
            text.
    """

    A: np.ndarray
    b: np.ndarray
    kept: np.ndarray
    label: Label = "row {}".format

    def about(self, i: int) -> tuple[str, ...]:
        """Returns the subject of row i, as names or a text."""
        return names_of(self.label(i))


@dc.dataclass(frozen=True, eq=False)
class Tracking:
    """Constraint that tracks a twist: J u + delta = V, with slack delta.

    Attributes:
        name: Name of this constraint in the program.
        J: Jacobian of the end effector in W, angular above translational, in
            the r tracked directions, shape (r, n_u).
        V: The desired twist V_WE in these directions, shape (r,) [rad/s, m/s].
        price: Weight of the squared slack, which adds 0.5 * price * |delta|^2
            to the cost (paper eq. 2).
        limit: Bounds of |delta|, shape (r,) [rad/s, m/s].
    """

    name: str
    J: np.ndarray
    V: np.ndarray
    price: float
    limit: np.ndarray


def tracking_name(term: str, effector: str) -> str:
    """Returns the name of the term that tracks an end effector's twist.

    Args:
        term: Name of the ingredient's terms.
        effector: Name of the end effector; empty if there is only one.
    """
    return f"{term} {effector}".rstrip()


@dc.dataclass(eq=False)
class Terms:
    """The terms of a program, keyed by name.

    Attributes:
        rows: Inequality rows A u <= b.
        linear: Vectors c of linear costs c'u, each of shape (n_u,).
        quadratic: Diagonals w of quadratic costs u' diag(w) u / 2, each of
            shape (n_u,).
        trackings: The constraints that track the twists of the end effectors.
    """

    rows: dict[str, Rows] = dc.field(default_factory=dict)
    linear: dict[str, np.ndarray] = dc.field(default_factory=dict)
    quadratic: dict[str, np.ndarray] = dc.field(default_factory=dict)
    trackings: dict[str, Tracking] = dc.field(default_factory=dict)
