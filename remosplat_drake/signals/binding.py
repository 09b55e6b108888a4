"""`Binding`: the active constraints of a tick's quadratic program."""

import dataclasses as dc
from typing import NamedTuple

import numpy as np

COLLISION = "collision"
"""Name of the rows against collision with the scene."""
JOINT_LIMIT = "joint limit"
"""Name of the rows for joint limits."""
SELF_COLLISION = "self-collision"
"""Name of the rows against self-collision."""
MOVER = "mover"
"""Name of the rows against collision with movers."""
BOUND = "bound"
"""Name of rows that are bounds on the command itself."""


class BoundRow(NamedTuple):
    """A constraint (row) of a tick's quadratic program, active at its optimum.

    Attributes:
        name: Name of its set of rows, `BOUND` for a bound on the command.
        index: Its index in that set.
        about: The names of the links or joints that it constrains, or a text.
    """

    name: str
    index: int
    about: tuple[str, ...]


@dc.dataclass(frozen=True, eq=False)
class Binding:
    """The active rows at the command, and the cost's negative gradient.

    At the optimum, the push is the sum of the rows, each times a non-negative
    multiplier (Karush, Kuhn and Tucker). Rows with large multipliers limit the
    command.

    Attributes:
        rows: The k rows.
        A: Coefficients of the rows in A u <= b, shape (k, n_u).
        push: Negative gradient of the cost at the command, shape (n_u,).
    """

    rows: tuple[BoundRow, ...]
    A: np.ndarray
    push: np.ndarray

    def __deepcopy__(self, memo) -> "Binding":
        return self


NONE_BINDS = Binding((), np.zeros((0, 0)), np.zeros(0))
"""The binding of a tick without an active row."""
