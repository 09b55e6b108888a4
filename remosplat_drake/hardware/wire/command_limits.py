"""Scales commands that are beyond the base's limits."""

import numpy as np
from numpy.typing import ArrayLike


def scaled_command(
    u: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> np.ndarray:
    """Scales a command by one factor, so that it is within its limits.

    If single entries were clamped, the robot would leave the path that was
    checked for clearance. With a multiple of the command, the robot stays on
    this path.

    Args:
        u: The command, shape (n_u,).
        lower: Lower bounds, none positive, shape (n_u,).
        upper: Upper bounds, none negative, shape (n_u,).

    Returns:
        The command times the largest factor up to 1 that is within the bounds,
        shape (n_u,).
    """
    bounds = np.where(u < 0, lower, upper)
    beyond = np.abs(u) > np.abs(bounds)
    return u * np.min(bounds[beyond] / u[beyond], initial=1.0)


TOLERANCE = 1e-3
"""Relative tolerance of bounds, since a solver's commands may exceed them by
rounding.
"""


def excess(
    u: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> tuple[int, float] | None:
    """Finds the first entry of a command that is beyond its bounds.

    The controller's quadratic program includes the bounds, so its commands
    exceed them only by rounding.

    Args:
        u: The command, shape (n_u,).
        lower: Lower bounds, none positive, shape (n_u,).
        upper: Upper bounds, none negative, shape (n_u,).

    Returns:
        The entry's index and its bound; None if there is none.
    """
    bounds = np.where(u < 0, lower, upper)
    slack = TOLERANCE * np.maximum(np.abs(bounds), TOLERANCE)
    beyond = np.flatnonzero(np.abs(u) > np.abs(bounds) + slack)
    return (int(beyond[0]), float(bounds[beyond[0]])) if len(beyond) else None


def command_bounds(
    n_u: int, base_lower: ArrayLike, base_upper: ArrayLike
) -> tuple[np.ndarray, np.ndarray]:
    """Makes bounds on a whole command from the bounds on its first entries.

    Args:
        n_u: Length of the command.
        base_lower: Lower bounds on the first entries.
        base_upper: Upper bounds on the first entries.

    Returns:
        Lower and upper bounds, shape (n_u,) each; they are infinite for the
        remaining entries.
    """
    lower, upper = np.full(n_u, -np.inf), np.full(n_u, np.inf)
    lower[: np.size(base_lower)] = base_lower
    upper[: np.size(base_upper)] = base_upper
    return lower, upper
