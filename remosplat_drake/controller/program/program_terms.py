"""The terms of a tick's program, keyed by name."""

import dataclasses as dc
from collections.abc import Callable

import numpy as np

Label = Callable[[int], str | tuple[str, ...]]
"""Function that returns the subject of a row by its index: names of links or
joints, or a text."""


def names_of(said: str | tuple[str, ...]) -> tuple[str, ...]:
    """Returns the subject of a row as a tuple of names; a text is one name.

    Args:
        said: The subject of the row, as returned by a `Label`.
    """
    return (said,) if isinstance(said, str) else said


def row_name(term: str, about: tuple[str, ...]) -> str:
    """Returns the name of a row for display.

    Args:
        term: Name of its set of rows.
        about: Its subject.
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
        label: Function that names row i: links or joints, or a text.
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
    """Tracking of a twist: J u + delta = V, with a cost of the slack delta.

    Attributes:
        name: The name of this tracking in the program.
        J: Jacobian of the end effector in W, angular above translational, in
            the r tracked directions, shape (r, n_u).
        V: The desired twist V_WE in these directions, shape (r,) [rad/s, m/s].
        price: Weight of the squared slack, which adds 0.5 * price * |delta|^2
            to the cost (paper eq. 2).
        limit: Bounds on |delta|, shape (r,) [rad/s, m/s].
    """

    name: str
    J: np.ndarray
    V: np.ndarray
    price: float
    limit: np.ndarray


def tracking_name(term: str, effector: str) -> str:
    """Returns the name of the term that tracks an end effector's twist.

    Args:
        term: Name of the term that tracks it.
        effector: Name of the end effector; empty if there is only one.
    """
    return f"{term} {effector}".rstrip()


@dc.dataclass(eq=False)
class Terms:
    """The terms of a program, keyed by name.

    Attributes:
        rows: Inequality rows A u <= b.
        linear: Vectors c of linear costs c'u, shape (n_u,) each.
        quadratic: Diagonals w of quadratic costs u' diag(w) u / 2, shape
            (n_u,) each.
        trackings: The trackings of the end effectors' twists.
    """

    rows: dict[str, Rows] = dc.field(default_factory=dict)
    linear: dict[str, np.ndarray] = dc.field(default_factory=dict)
    quadratic: dict[str, np.ndarray] = dc.field(default_factory=dict)
    trackings: dict[str, Tracking] = dc.field(default_factory=dict)
