"""Computes directions that are evenly distributed over the unit sphere."""

import numpy as np


def spread_directions(n: int) -> np.ndarray:
    """Returns unit vectors spread evenly over the sphere (Fibonacci spiral).

    Args:
        n: Number of vectors.

    Returns:
        The unit vectors, shape (n, 3).
    """
    z = 1 - (2 * np.arange(n) + 1) / n
    angle = np.arange(n) * np.pi * (3 - np.sqrt(5))
    rho = np.sqrt(1 - z**2)
    return np.column_stack([rho * np.cos(angle), rho * np.sin(angle), z])
