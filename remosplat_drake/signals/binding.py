"""`Binding`: the active constraints of a tick's quadratic program."""

import dataclasses as dc
from typing import NamedTuple

import numpy as np

COLLISION = "collision"
"""Name of the constraints against collision with the scene."""
JOINT_LIMIT = "joint limit"
"""Name of the constraints for joint limits."""
SELF_COLLISION = "self-collision"
"""Name of the constraints against self-collision."""
MOVER = "mover"
"""Name of the constraints against collision with movers."""
BOUND = "bound"
"""Name of the bounds on the entries of the command."""


class BoundRow(NamedTuple):
    """A constraint (row) that is active at the optimum of a quadratic program.

    Attributes:
        name: Name of the set of rows that contains this row; `BOUND` for a
            bound on the command.
        index: Index of the row in this set.
        about: The names of the links or joints that the row constrains, or a
            text.
    """

    name: str
    index: int
    about: tuple[str, ...]


@dc.dataclass(frozen=True, eq=False)
class Binding:
    """The active rows at the optimum, and the negative gradient of the cost.

    At the optimum, the negative gradient `push` is the sum of the rows, each
    times a non-negative multiplier (Karush, Kuhn and Tucker). The rows with
    large multipliers are those that limit the command.

    Attributes:
        rows: The k active rows.
        A: Coefficients of the active rows in A u <= b, shape (k, n_u).
        push: Negative gradient of the cost at the command, shape (n_u,).
    """

    rows: tuple[BoundRow, ...]
    A: np.ndarray
    push: np.ndarray

    def __deepcopy__(self, memo) -> "Binding":
        return self


NONE_BINDS = Binding((), np.zeros((0, 0)), np.zeros(0))
"""The `Binding` of a tick without an active row."""
