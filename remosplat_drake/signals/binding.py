"""`Binding`: which rows of a tick's program hold its command back."""

import dataclasses as dc
from typing import NamedTuple

import numpy as np

COLLISION = "collision"
"""Name of the rows that keep the robot off the scene."""
JOINT_LIMIT = "joint limit"
"""Name of the rows that keep joints off their limits."""
SELF_COLLISION = "self-collision"
"""Name of the rows that keep the robot off itself."""
MOVER = "mover"
"""Name of the rows that keep the robot off what moves."""
BOUND = "bound"
"""Name of rows that are bounds on the command itself."""


class BoundRow(NamedTuple):
    """A row of the program that holds with equality.

    Attributes:
        name: Name of its set of rows, `BOUND` for a bound on the command.
        index: Its number in that set.
        about: What it is about: names of links or joints, or a text.
    """

    name: str
    index: int
    about: tuple[str, ...]


@dc.dataclass(frozen=True, eq=False)
class Binding:
    """The rows that hold with equality at the command, and what pushes there.

    At the optimum of a program the push is the sum of its rows, each times a
    multiplier of at least zero (Karush, Kuhn and Tucker): rows with a large one
    are what holds the command back.

    Attributes:
        rows: The k rows.
        A: Coefficients of the rows in A u <= b, shape (k, n_u).
        push: Direction in which the cost falls at the command, shape (n_u,).
    """

    rows: tuple[BoundRow, ...]
    A: np.ndarray
    push: np.ndarray

    def __deepcopy__(self, memo) -> "Binding":
        return self


NONE_BINDS = Binding((), np.zeros((0, 0)), np.zeros(0))
"""No row holds with equality."""
