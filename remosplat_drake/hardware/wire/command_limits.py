"""A command within the base's limits, scaled as a whole."""

import numpy as np


def scaled_command(
    u: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> np.ndarray:
    """The longest multiple of a command that is within limits.

    Cutting single entries would turn the robot off the path that was checked
    for clearance; a multiple stays on it.

    Args:
        u: The command, shape (n_u,).
        lower: Lower bounds, none positive, shape (n_u,).
        upper: Upper bounds, none negative, shape (n_u,).
    """
    bounds = np.where(u < 0, lower, upper)
    beyond = np.abs(u) > np.abs(bounds)
    return u * np.min(bounds[beyond] / u[beyond], initial=1.0)


TOLERANCE = 1e-3
"""What solvers may leave beyond a bound, relative to it."""


def excess(
    u: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> tuple[int, float] | None:
    """The first entry of a command beyond its bounds, and its bound.

    The program knows the bounds: but for rounding, nothing is beyond them.

    Args:
        u: The command, shape (n_u,).
        lower: Lower bounds, none positive, shape (n_u,).
        upper: Upper bounds, none negative, shape (n_u,).
    """
    bounds = np.where(u < 0, lower, upper)
    slack = TOLERANCE * np.maximum(np.abs(bounds), TOLERANCE)
    beyond = np.flatnonzero(np.abs(u) > np.abs(bounds) + slack)
    return (int(beyond[0]), float(bounds[beyond[0]])) if len(beyond) else None


def command_bounds(
    n_u: int, base_lower: list[float], base_upper: list[float]
) -> tuple[np.ndarray, np.ndarray]:
    """Bounds on the whole command from those on its first entries."""
    lower, upper = np.full(n_u, -np.inf), np.full(n_u, np.inf)
    lower[: len(base_lower)] = base_lower
    upper[: len(base_upper)] = base_upper
    return lower, upper
