"""`SlackForm`: the program of a tick in command and slack, as matrices."""

from typing import NamedTuple

import numpy as np


class SlackForm(NamedTuple):
    """The program in x = (u, delta): minimise 1/2 x'Q x + c'x.

    It contains the sum of the costs and the rows of all ingredients, except the
    rows that the bounds of u imply.

    Attributes:
        lower: Lower bounds on u, shape (n_u,).
        upper: Upper bounds on u, shape (n_u,).
        slack_lower: Lower bounds of delta, shape (r,); -inf for a bound that
            the bounds of u imply.
        slack_upper: Upper bounds of delta, shape (r,); inf for a bound that the
            bounds of u imply.
        A: Coefficients of the kept rows A u <= b, shape (m, n_u).
        b: Right-hand sides of these rows, shape (m,).
        J: Coefficients of the constraints J x = V of the tracked twists, shape
            (r, n_u + r).
        V: The tracked twists, shape (r,).
        Q: Matrix of the cost, shape (n_u + r, n_u + r).
        c: Vector of the cost, shape (n_u + r,).
    """

    lower: np.ndarray
    upper: np.ndarray
    slack_lower: np.ndarray
    slack_upper: np.ndarray
    A: np.ndarray
    b: np.ndarray
    J: np.ndarray
    V: np.ndarray
    Q: np.ndarray
    c: np.ndarray
